// SPDX-License-Identifier: MIT
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "mscomp/base/atomic_file.h"
#include "mscomp/convert/zip.h"
#include "zip_format.h"

namespace mscomp {
namespace {

using namespace zip;

constexpr std::uint16_t kVersion64 = 45;
constexpr std::uint16_t kFirstOfJanuary1980 = 1 << 5 | 1;  // always: equal input, equal bytes

/// A record of little-endian fields, one behind the other.
class Fields {
  public:
    template <class T>
    Fields& add(T value) {
        static_assert(std::endian::native == std::endian::little, "the file is little-endian");
        char raw[sizeof(T)];
        std::memcpy(raw, &value, sizeof(T));
        bytes_.append(raw, sizeof(T));
        return *this;
    }
    Fields& add_text(const std::string& text) {
        bytes_ += text;
        return *this;
    }
    const std::string& bytes() const { return bytes_; }

  private:
    std::string bytes_;
};

using U16 = std::uint16_t;
using U32 = std::uint32_t;
using U64 = std::uint64_t;

/// From the version to the length of the name; local and central records share it.
void add_description(Fields& fields, const std::string& name, std::uint32_t crc) {
    fields.add(kVersion64).add(kDescriptorFlag).add(kStored);
    fields.add(U16{0}).add(kFirstOfJanuary1980);  // time, date
    fields.add(crc).add(kSee64).add(kSee64).add(static_cast<U16>(name.size()));
}

}  // namespace

void ZipWriter::put(const std::string& bytes) {
    file_.write(std::string_view(bytes));
    position_ += bytes.size();
}

void ZipWriter::begin_file(const std::string& name) {
    end_file();
    entries_.push_back({name, position_, 0, 0});
    is_open_ = true;
    // Size and checksum are not known yet: they follow the data.
    Fields local;
    local.add(kLocalSignature);
    add_description(local, name, 0);
    local.add(U16{20}).add_text(name);  // length of the extra field
    local.add(kExtra64).add(U16{16}).add(U64{0}).add(U64{0});
    put(local.bytes());
}

void ZipWriter::write(std::span<const std::byte> bytes) {
    constexpr std::size_t piece = std::size_t{1} << 20;  // zlib counts in 32 bits
    Entry& entry = entries_.back();
    for (std::size_t at = 0; at < bytes.size(); at += piece) {
        entry.crc =
            static_cast<U32>(::crc32(entry.crc, reinterpret_cast<const Bytef*>(bytes.data()) + at,
                                     static_cast<uInt>(std::min(piece, bytes.size() - at))));
    }
    file_.write(bytes);
    entry.size += bytes.size();
    position_ += bytes.size();
}

void ZipWriter::write(std::string_view bytes) {
    write(std::as_bytes(std::span<const char>(bytes.data(), bytes.size())));
}

void ZipWriter::end_file() {
    if (!is_open_) return;
    is_open_ = false;
    const Entry& entry = entries_.back();
    Fields descriptor;
    descriptor.add(kDescriptorSignature).add(entry.crc).add(entry.size).add(entry.size);
    put(descriptor.bytes());
}

void ZipWriter::finish() {
    end_file();
    const U64 begin = position_;
    for (const Entry& entry : entries_) {
        Fields central;
        central.add(kCentralSignature).add(kVersion64);
        add_description(central, entry.name, entry.crc);
        central.add(U16{28}).add(U16{0}).add(U16{0});  // extra, comment, disk
        central.add(U16{0}).add(U32{0}).add(kSee64);   // attributes, position
        central.add_text(entry.name).add(kExtra64).add(U16{24});
        central.add(entry.size).add(entry.size).add(entry.begin);
        put(central.bytes());
    }
    const U64 end = position_, count = entries_.size();
    Fields record;
    record.add(kEnd64Signature).add(kEnd64Length - 12).add(kVersion64).add(kVersion64);
    record.add(U32{0}).add(U32{0}).add(count).add(count).add(end - begin).add(begin);
    record.add(kLocator64Signature).add(U32{0}).add(end).add(U32{1});
    record.add(kEndSignature).add(U16{0}).add(U16{0}).add(kSee64Short).add(kSee64Short);
    record.add(kSee64).add(kSee64).add(U16{0});
    put(record.bytes());
}

}  // namespace mscomp

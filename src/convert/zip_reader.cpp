// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "mscomp/base/error.h"
#include "mscomp/base/file_kind.h"
#include "mscomp/convert/zip.h"
#include "zip_format.h"

namespace mscomp {
namespace {

using namespace zip;
using Bytes = std::span<const std::byte>;

template <class T>
T number_at(Bytes bytes, std::uint64_t at) {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    return value;
}

struct Directory {
    std::uint64_t begin = 0, end = 0, entries = 0;
};

/// A file as the directory has it.
struct Record {
    std::string name;
    std::uint16_t flags = 0, method = 0;
    std::uint32_t crc = 0;
    std::uint64_t packed = 0, size = 0, local = 0;
};

class DirectoryReader {
  public:
    DirectoryReader(Bytes bytes, const std::string& path, const ZipLimits& limits)
        : bytes_(bytes), path_(path), limits_(limits) {}

    std::vector<ZipEntry> read() {
        const std::string_view text(reinterpret_cast<const char*>(bytes_.data()), bytes_.size());
        if (!text.starts_with("PK")) refuse_other_kinds(text, path_);
        const Directory directory = find_directory();
        if (directory.entries > limits_.entries) {
            fail(fmt::format("holds {} files, wanted at most {}", directory.entries,
                             limits_.entries));
        }
        std::vector<ZipEntry> entries;
        std::set<std::string> names;
        std::uint64_t at = directory.begin;
        for (std::uint64_t i = 0; i < directory.entries; ++i) {
            const Record record = read_record(at, directory.end);
            if (!names.insert(record.name).second) {
                fail(fmt::format("names '{}' twice", record.name));
            }
            entries.push_back(locate(record, directory.begin));
        }
        if (at != directory.end) fail("its directory is longer than its entries");
        refuse_overlap();
        return entries;
    }

  private:
    /// The end record stands last, behind it at most a comment.
    std::uint64_t find_end() const {
        constexpr std::uint64_t longest_comment = 0xFFFF;
        if (bytes_.size() < kEndLength) fail("is not a zip archive or is truncated");
        const std::uint64_t last = bytes_.size() - kEndLength;
        for (std::uint64_t back = 0; back <= std::min(last, longest_comment); ++back) {
            const std::uint64_t at = last - back;
            if (number_at<std::uint32_t>(bytes_, at) == kEndSignature &&
                number_at<std::uint16_t>(bytes_, at + 20) == back) {
                return at;
            }
        }
        fail("is not a zip archive or is truncated: it has no directory at its end");
    }

    Directory find_directory() const {
        const std::uint64_t end = find_end();
        Directory directory;
        std::uint64_t size = 0;
        std::uint64_t record = end;
        const bool has64 =
            end >= kLocator64Length + kEnd64Length &&
            number_at<std::uint32_t>(bytes_, end - kLocator64Length) == kLocator64Signature;
        if (has64) {
            record = number_at<std::uint64_t>(bytes_, end - kLocator64Length + 8);
            if (record != end - kLocator64Length - kEnd64Length ||
                number_at<std::uint32_t>(bytes_, record) != kEnd64Signature) {
                fail("its zip64 end record is not where it should be");
            }
            require_one_disk(number_at<std::uint32_t>(bytes_, record + 16),
                             number_at<std::uint32_t>(bytes_, record + 20));
            directory.entries = number_at<std::uint64_t>(bytes_, record + 32);
            size = number_at<std::uint64_t>(bytes_, record + 40);
            directory.begin = number_at<std::uint64_t>(bytes_, record + 48);
        } else {
            require_one_disk(number_at<std::uint16_t>(bytes_, end + 4),
                             number_at<std::uint16_t>(bytes_, end + 6));
            directory.entries = number_at<std::uint16_t>(bytes_, end + 10);
            size = number_at<std::uint32_t>(bytes_, end + 12);
            directory.begin = number_at<std::uint32_t>(bytes_, end + 16);
        }
        if (size > record || directory.begin != record - size) {
            fail(fmt::format("its directory should be {} bytes at byte {}, but ends at byte {}",
                             size, directory.begin, record));
        }
        directory.end = record;
        return directory;
    }

    void require_one_disk(std::uint32_t here, std::uint32_t first) const {
        if (here != 0 || first != 0) fail("is one part of a split archive, wanted a whole one");
    }

    Record read_record(std::uint64_t& at, std::uint64_t end) const {
        if (end - at < kCentralLength ||
            number_at<std::uint32_t>(bytes_, at) != kCentralSignature) {
            fail(fmt::format("has no directory entry at byte {}", at));
        }
        Record record;
        record.flags = number_at<std::uint16_t>(bytes_, at + 8);
        record.method = number_at<std::uint16_t>(bytes_, at + 10);
        record.crc = number_at<std::uint32_t>(bytes_, at + 16);
        record.packed = number_at<std::uint32_t>(bytes_, at + 20);
        record.size = number_at<std::uint32_t>(bytes_, at + 24);
        record.local = number_at<std::uint32_t>(bytes_, at + 42);
        const std::uint64_t name = number_at<std::uint16_t>(bytes_, at + 28);
        const std::uint64_t extra = number_at<std::uint16_t>(bytes_, at + 30);
        const std::uint64_t comment = number_at<std::uint16_t>(bytes_, at + 32);
        if (end - at < kCentralLength + name + extra + comment) {
            fail(fmt::format("its directory entry at byte {} is longer than the directory", at));
        }
        record.name.assign(reinterpret_cast<const char*>(bytes_.data()) + at + kCentralLength,
                           name);
        read_extra(bytes_.subspan(at + kCentralLength + name, extra), record);
        at += kCentralLength + name + extra + comment;
        return record;
    }

    /// The sizes and the position that do not fit 32 bits stand there, in this order.
    void read_extra(Bytes extra, Record& record) const {
        while (extra.size() >= 4) {
            const auto kind = number_at<std::uint16_t>(extra, 0);
            const std::size_t length = number_at<std::uint16_t>(extra, 2);
            if (length > extra.size() - 4) fail("has a directory entry with a broken extra field");
            Bytes field = extra.subspan(4, length);
            extra = extra.subspan(4 + length);
            if (kind != kExtra64) continue;
            for (std::uint64_t* value : {&record.size, &record.packed, &record.local}) {
                if (*value != kSee64) continue;
                if (field.size() < 8) fail("has a directory entry with a short zip64 field");
                *value = number_at<std::uint64_t>(field, 0);
                field = field.subspan(8);
            }
            return;
        }
    }

    ZipEntry locate(const Record& record, std::uint64_t directory_begin) {
        const std::string name = "'" + record.name + "' ";
        if ((record.flags & kEncryptedFlags) != 0) fail(name + "is encrypted, wanted plain files");
        if (record.method != kStored && record.method != kDeflated) {
            fail(fmt::format("{}is packed with method {}, wanted stored (0) or deflated (8)", name,
                             record.method));
        }
        if (directory_begin < kLocalLength || record.local > directory_begin - kLocalLength ||
            number_at<std::uint32_t>(bytes_, record.local) != kLocalSignature) {
            fail(
                fmt::format("{}should begin at byte {}, where no file begins", name, record.local));
        }
        const std::uint64_t name_length = number_at<std::uint16_t>(bytes_, record.local + 26);
        const std::uint64_t extra_length = number_at<std::uint16_t>(bytes_, record.local + 28);
        const std::uint64_t begin = record.local + kLocalLength + name_length + extra_length;
        if (begin > directory_begin || record.packed > directory_begin - begin) {
            fail(fmt::format("{}is truncated: {} bytes from byte {} on, the directory begins at {}",
                             name, record.packed, begin, directory_begin));
        }
        const std::string_view local_name(
            reinterpret_cast<const char*>(bytes_.data()) + record.local + kLocalLength,
            name_length);
        if (local_name != record.name ||
            number_at<std::uint16_t>(bytes_, record.local + 8) != record.method) {
            fail(name + "differs from its entry in the directory");
        }
        taken_.emplace_back(record.local, begin + record.packed);
        check_size(record, name);
        return {record.name, record.method == kDeflated, record.crc, record.size,
                bytes_.subspan(begin, record.packed)};
    }

    void check_size(const Record& record, const std::string& name) {
        if (record.method == kStored) {
            if (record.size == record.packed) return;
            fail(fmt::format("{}is stored with {} bytes instead of {}", name, record.packed,
                             record.size));
        }
        const std::uint64_t floor = std::uint64_t{64} << 20;
        const std::uint64_t most =
            std::min(limits_.unpacked, floor + limits_.ratio * bytes_.size());
        if (record.size > most || unpacked_ > most - record.size) {
            fail(
                fmt::format("{}would unpack to {} bytes, wanted at most {} in all from an archive "
                            "of {}; save it uncompressed if it is sound",
                            name, record.size, most, bytes_.size()));
        }
        unpacked_ += record.size;
    }

    void refuse_overlap() {
        std::sort(taken_.begin(), taken_.end());
        for (std::size_t i = 1; i < taken_.size(); ++i) {
            if (taken_[i].first < taken_[i - 1].second) fail("has files that overlap each other");
        }
    }

    [[noreturn]] void fail(const std::string& message) const { throw InputError({path_}, message); }

    Bytes bytes_;
    const std::string& path_;
    const ZipLimits& limits_;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> taken_;  // [begin, end) of every file
    std::uint64_t unpacked_ = 0;
};

}  // namespace

std::vector<ZipEntry> read_zip_entries(std::span<const std::byte> bytes, const std::string& path,
                                       const ZipLimits& limits) {
    return DirectoryReader(bytes, path, limits).read();
}

}  // namespace mscomp

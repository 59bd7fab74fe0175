// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <new>

#include "mscomp/base/error.h"
#include "mscomp/convert/zip.h"

namespace mscomp {
namespace {

using Bytes = std::span<const std::byte>;

/// zlib counts in 32 bits.
constexpr std::size_t kPiece = std::size_t{1} << 20;

std::uint32_t crc_of(Bytes bytes) {
    uLong crc = ::crc32(0, nullptr, 0);
    for (std::size_t at = 0; at < bytes.size(); at += kPiece) {
        crc = ::crc32(crc, reinterpret_cast<const Bytef*>(bytes.data()) + at,
                      static_cast<uInt>(std::min(kPiece, bytes.size() - at)));
    }
    return static_cast<std::uint32_t>(crc);
}

class Inflater {
  public:
    Inflater() {
        // Negative: raw deflate data, as a zip archive has them.
        if (::inflateInit2(&stream_, -MAX_WBITS) != Z_OK) throw std::bad_alloc();
    }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;
    ~Inflater() { ::inflateEnd(&stream_); }

    /// Appends to `output` what `input` unpacks to; false if it is damaged, does not end where the
    /// input ends, or unpacks to more than `most` bytes.
    bool unpack(Bytes input, std::uint64_t most, std::vector<std::byte>& output) {
        std::size_t used = 0;
        for (int state = Z_OK; state != Z_STREAM_END;) {
            if (stream_.avail_in == 0 && used < input.size()) {
                const std::size_t count = std::min(kPiece, input.size() - used);
                // zlib does not write there, its type only says so.
                stream_.next_in =
                    const_cast<Bytef*>(reinterpret_cast<const Bytef*>(input.data()) + used);
                stream_.avail_in = static_cast<uInt>(count);
                used += count;
            }
            const std::size_t before = output.size();
            // One byte of room beyond `most` tells too much from just enough.
            const std::uint64_t room = std::min<std::uint64_t>(kPiece, most + 1 - before);
            output.resize(before + room);
            stream_.next_out = reinterpret_cast<Bytef*>(output.data()) + before;
            stream_.avail_out = static_cast<uInt>(room);
            state = ::inflate(&stream_, Z_NO_FLUSH);
            output.resize(before + room - stream_.avail_out);
            if (output.size() > most || (state != Z_OK && state != Z_STREAM_END)) return false;
        }
        return used == input.size() && stream_.avail_in == 0;
    }

  private:
    z_stream stream_{};
};

}  // namespace

std::span<const std::byte> unpack(const ZipEntry& entry, const std::string& path,
                                  std::vector<std::byte>& storage) {
    std::span<const std::byte> bytes = entry.packed;
    if (entry.deflated) {
        storage.clear();
        const bool sound = Inflater().unpack(entry.packed, entry.size, storage);
        if (!sound || storage.size() != entry.size) {
            throw InputError({path}, fmt::format("'{}' is damaged: it does not unpack to its {} "
                                                 "bytes",
                                                 entry.name, entry.size));
        }
        bytes = storage;
    }
    if (crc_of(bytes) != entry.crc) {
        throw InputError({path}, fmt::format("'{}' does not match its checksum; the file was "
                                             "altered or damaged after it was written",
                                             entry.name));
    }
    return bytes;
}

}  // namespace mscomp

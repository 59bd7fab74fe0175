// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace mscomp {

class AtomicFile;

/// One file of a zip archive: where its bytes lie in the archive, which has to outlive it.
struct ZipEntry {
    std::string name;
    bool deflated = false;
    std::uint32_t crc = 0;
    std::uint64_t size = 0;  // unpacked
    std::span<const std::byte> packed;
};

/// What an archive may ask for, so that a small hostile file cannot fill the memory.
struct ZipLimits {
    std::size_t entries = 1000;
    std::uint64_t unpacked = std::uint64_t{1} << 34;  // bytes of all deflated entries together
    std::uint64_t ratio = 200;                        // of these to the archive, beyond 64 MiB
};

/// The files of the archive `bytes`, stored or deflated, zip64 included. Nothing is unpacked.
/// Throws InputError for archives that are truncated, encrypted or split, whose directory and files
/// contradict or overlap each other, that name a file twice or ask for more than `limits`.
std::vector<ZipEntry> read_zip_entries(std::span<const std::byte> bytes, const std::string& path,
                                       const ZipLimits& limits = {});

/// The bytes of `entry`: where they lie if stored, otherwise unpacked into `storage`. Memory grows
/// with what is really there. Throws InputError if they differ from the size or the CRC-32
/// declared.
std::span<const std::byte> unpack(const ZipEntry& entry, const std::string& path,
                                  std::vector<std::byte>& storage);

/// Writes a zip archive of stored files into `file`, piece by piece, in the 64-bit form: begin a
/// file, write its bytes, begin the next; finish, then commit the file.
class ZipWriter {
  public:
    explicit ZipWriter(AtomicFile& file) : file_(file) {}

    void begin_file(const std::string& name);
    void write(std::span<const std::byte> bytes);
    void write(std::string_view bytes);
    void finish();

  private:
    struct Entry {
        std::string name;
        std::uint64_t begin = 0, size = 0;
        std::uint32_t crc = 0;
    };
    void put(const std::string& bytes);
    void end_file();

    AtomicFile& file_;
    std::vector<Entry> entries_;
    bool is_open_ = false;
    std::uint64_t position_ = 0;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>

namespace mscomp {

class TemporaryFile;

/// Which ranges of the data of a file were written, and the hash of each, so that one reading from
/// end to end can tell whether the disk holds what it was given.
class WrittenPieces {
  public:
    /// Throws std::logic_error if the range cuts through one that was noted before. Thread-safe.
    void note(std::uint64_t begin, std::span<const std::byte> bytes);
    /// Whether `bytes`, read from `begin` on, are those that were noted. Throws std::logic_error if
    /// the range cuts through a piece. Thread-safe.
    bool agrees(std::uint64_t begin, std::span<const std::byte> bytes) const;
    /// First byte below `size` that no piece covers.
    std::optional<std::uint64_t> first_hole(std::uint64_t size) const;
    /// Reads the `size` bytes that start at byte `data_begin` of `file`: XXH3-64 of them all.
    /// Throws IoError if a piece is not what was noted.
    std::uint64_t checked_hash(const TemporaryFile& file, std::uint64_t data_begin,
                               std::uint64_t size) const;

  private:
    struct Piece {
        std::uint64_t end;
        std::uint64_t hash;
    };
    std::map<std::uint64_t, Piece> pieces_;  // by their first byte, without overlap
    mutable std::mutex mutex_;
};

}  // namespace mscomp

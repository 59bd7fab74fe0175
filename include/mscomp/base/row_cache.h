// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

namespace mscomp {

/// Rows of numbers by key, kept up to a limit in bytes: those used longest ago go first. Rows found
/// or put since start_round() never go, so that a round may exceed the limit by what it needs.
class RowCache {
  public:
    explicit RowCache(std::size_t limit_bytes) : limit_(limit_bytes) {}

    /// Rows of earlier rounds may go from now on.
    void start_round() { ++round_; }
    /// The row of `key`, which stays where it is until the next start_round().
    std::optional<std::span<const double>> find(int key);
    /// `key` must not be there.
    std::span<const double> put(int key, std::vector<double> row);

    std::size_t row_count() const { return entries_.size(); }
    std::size_t bytes() const { return bytes_; }

  private:
    struct Entry {
        std::vector<double> row;
        std::list<int>::iterator use;  // in uses_
        std::uint64_t round;
    };

    void drop_what_may_go();

    std::size_t limit_;
    std::size_t bytes_ = 0;
    std::uint64_t round_ = 0;
    std::list<int> uses_;  // keys, used last first
    std::unordered_map<int, Entry> entries_;
};

}  // namespace mscomp

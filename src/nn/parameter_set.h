// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mscomp/base/index.h"
#include "nn/zeroed_array.h"

namespace mscomp::nn {

using Extents = std::vector<std::int64_t>;
std::int64_t element_count(const Extents& extents);

/// All parameters of a model, their gradients and Adam's two moments: one allocation each, so that
/// saving, zeroing and updating are loops. Entries are named and start on cache lines. What is
/// never written to takes up no memory.
template <class T>
class ParameterSet {
  public:
    struct Entry {
        std::string name;
        Extents extents;
        std::int64_t offset;  // into each allocation
        std::int64_t count;
        double rate_scale = 1;  // factor of the learning rate
    };

    /// Adds a zero-filled parameter and returns its index. Spans taken before become invalid.
    int add(std::string name, Extents extents);

    int count() const { return static_cast<int>(entries_.size()); }
    const Entry& entry(int index) const { return entries_[at(index)]; }

    std::span<T> value(int index) { return slice(values_, index); }
    std::span<const T> value(int index) const { return slice(values_, index); }
    std::span<T> grad(int index) { return slice(grads_, index); }
    std::span<const T> grad(int index) const { return slice(grads_, index); }
    std::span<T> moment1(int index) { return slice(moments1_, index); }
    std::span<const T> moment1(int index) const { return slice(moments1_, index); }
    std::span<T> moment2(int index) { return slice(moments2_, index); }
    std::span<const T> moment2(int index) const { return slice(moments2_, index); }

    /// The whole allocations (alignment gaps are zero and stay zero).
    std::span<T> all_values() { return values_; }
    std::span<T> all_grads() { return grads_; }
    std::span<const T> all_grads() const { return grads_; }
    std::span<T> all_moments1() { return moments1_; }
    std::span<T> all_moments2() { return moments2_; }
    void zero_grad();

    /// Elements [first, last) of a parameter or of the whole allocations.
    struct Range {
        std::int64_t first = 0, last = 0;
    };
    /// Says where parameter `index` can have a gradient: rising ranges of its elements, everything
    /// at first. What is not live is zero in gradients and moments and stays as it is in steps.
    void set_live(int index, std::vector<Range> ranges);
    void set_rate_scale(int index, double scale);
    /// All live elements, each piece of one parameter, cut whatever the number of threads.
    int live_piece_count() const { return static_cast<int>(first_of_piece_.size()) - 1; }
    std::span<const Range> live_piece(int piece) const {
        const auto i = at(piece);
        return std::span(live_).subspan(first_of_piece_[i],
                                        first_of_piece_[i + 1] - first_of_piece_[i]);
    }
    /// All values zero, as before their first use. Spans stay valid.
    void reset_values() { values_.reset(); }

    double rate_scale_of(int piece) const {
        const int entry = entry_of_piece_[at(piece)];
        return entries_[at(entry)].rate_scale;
    }

  private:
    void cut_live();

    template <class Vector>
    auto slice(Vector& all, int index) const {
        const Entry& e = entry(index);
        return std::span(all).subspan(at(e.offset), at(e.count));
    }

    std::vector<Entry> entries_;
    std::vector<std::vector<Range>> live_of_entry_;  // elements of each parameter
    std::vector<Range> live_;                        // of the allocations
    std::vector<std::size_t> first_of_piece_{0};     // into live_
    std::vector<int> entry_of_piece_;
    ZeroedArray<T> values_, grads_, moments1_, moments2_;
};

}  // namespace mscomp::nn

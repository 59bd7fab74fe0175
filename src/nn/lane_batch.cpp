// SPDX-License-Identifier: MIT
#include "nn/lane_batch.h"

#include <algorithm>
#include <cassert>

#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "nn/dim.h"

namespace mscomp::nn {
namespace {

constexpr int kLanes = 16;              // shapes read side by side
constexpr std::int64_t kVertices = 32;  // of a tile, which stays in the first cache
constexpr std::int64_t kColumns = kVertices * kDim;
constexpr std::int64_t kChunk = 64 * kVertices;

template <class T>
struct FourOf {
    typedef T type __attribute__((vector_size(4 * sizeof(T)), may_alias, aligned(sizeof(T))));
};

/// Some shapes, at most kLanes, on their way into the lanes from `first` on.
template <class T>
class LaneGroup {
  public:
    LaneGroup(const ScaledFeatures& features, const VertexOrder& order, std::span<T> rows)
        : features_(features), order_(order), rows_(rows) {
        lanes_ = static_cast<std::int64_t>(rows.size()) / (order.vertex_count() * kDim);
        for (std::int64_t i = 0; i < kColumns; ++i) {
            offset_[i] = features.scale.offset[at(i % kDim)];
            factor_[i] = features.scale.factor[at(i % kDim)];
        }
    }

    std::int64_t lanes() const { return lanes_; }

    void choose(std::int64_t first, std::span<const int> which) {
        first_ = first;
        width_ = static_cast<int>(std::min<std::int64_t>(kLanes, lanes_ - first));
        std::ranges::fill(shapes_, nullptr);
        for (std::size_t l = 0; l < which.size(); ++l) {
            shapes_[l] = features_.shapes.shape(which[l]).data();
        }
    }

    /// Vertices [begin, end) of the user. They are read one after the other, and the rows of each
    /// written as a whole, wherever it lies inside: that is kinder to the memory than the reverse.
    void move(std::int64_t begin, std::int64_t end) const {
        for (std::int64_t v = begin; v < end; v += kVertices) {
            const std::int64_t next = v + kVertices;
            move_tile(v, std::min(next, end), std::min(next, end), std::min(next + kVertices, end));
        }
    }

  private:
    T* rows_of(std::int64_t vertex) const {
        return rows_.data() + order_.to_internal[at(vertex)] * kDim * lanes_ + first_;
    }

    /// Vertices [begin, end) while memory is asked for [next, next_end).
    void move_tile(std::int64_t begin, std::int64_t end, std::int64_t next,
                   std::int64_t next_end) const {
        alignas(64) float tile[kLanes][kColumns];
        const std::int64_t columns = (end - begin) * kDim;
        for (int l = 0; l < width_; ++l) {
            // A few at a time: the processor waits where too many are asked for.
            for (std::int64_t v = next + l; v < next_end; v += width_) {
                for (std::int64_t c = 0; c < kDim; ++c) {
                    __builtin_prefetch(rows_of(v) + c * lanes_, 1);
                }
            }
            if (shapes_[l] == nullptr) {
                std::fill_n(tile[l], columns, 0.0F);
                continue;
            }
            for (std::int64_t i = next * kDim; i < next_end * kDim; i += 16) {
                __builtin_prefetch(shapes_[l] + i);
            }
            if (features_.scale.roots.empty()) {
                scale(shapes_[l] + begin * kDim, columns, tile[l]);
            } else {
                scale_with_roots(begin, end, shapes_[l] + begin * kDim, tile[l]);
            }
        }
        T* to[kColumns];
        for (std::int64_t i = 0; i < columns; ++i) {
            to[i] = rows_of(begin + i / kDim) + i % kDim * lanes_;
        }
        const std::int64_t whole = columns / 4 * 4;
        for (std::int64_t i = 0; i < whole; i += 4) {
            for (int l = 0; l < width_; l += 4) transpose(tile, l, i, to);
        }
        for (std::int64_t i = whole; i < columns; ++i) {
            for (int l = 0; l < width_; ++l) to[i][l] = static_cast<T>(tile[l][i]);
        }
    }

    void scale(const float* from, std::int64_t count, float* to) const {
#pragma omp simd
        for (std::int64_t i = 0; i < count; ++i) {
            to[i] = static_cast<float>((static_cast<double>(from[i]) - offset_[i]) * factor_[i]);
        }
    }

    void scale_with_roots(std::int64_t begin, std::int64_t end, const float* from,
                          float* to) const {
        for (std::int64_t v = begin; v < end; ++v) {
            const double root = features_.scale.root(at(v));
            for (std::int64_t c = 0; c < kDim; ++c, ++from, ++to) {
                *to = static_cast<float>((static_cast<double>(*from) - offset_[c]) *
                                         (factor_[c] * root));
            }
        }
    }

    /// Four lanes of four columns.
    static void transpose(const float (&tile)[kLanes][kColumns], int l, std::int64_t i, T** to) {
        using Four = typename FourOf<float>::type;
        const auto row = [&](int k) { return *reinterpret_cast<const Four*>(&tile[l + k][i]); };
        const Four a = row(0), b = row(1), c = row(2), d = row(3);
        const Four ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5);
        const Four ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
        const Four cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5);
        const Four cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
        put(__builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5), to[i] + l);
        put(__builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7), to[i + 1] + l);
        put(__builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5), to[i + 2] + l);
        put(__builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7), to[i + 3] + l);
    }
    static void put(typename FourOf<float>::type four, T* to) {
        *reinterpret_cast<typename FourOf<T>::type*>(to) =
            __builtin_convertvector(four, typename FourOf<T>::type);
    }

    const ScaledFeatures& features_;
    const VertexOrder& order_;
    std::span<T> rows_;
    std::int64_t lanes_ = 0, first_ = 0;
    int width_ = 0;
    const float* shapes_[kLanes] = {};
    double offset_[kColumns], factor_[kColumns];
};

}  // namespace

template <class T>
void gather_lanes(const ScaledFeatures& features, std::span<const int> which,
                  const VertexOrder& order, std::span<T> rows, GatherThreads threads) {
    const std::int64_t vertices = order.vertex_count();
    LaneGroup<T> group(features, order, rows);
    assert(static_cast<std::int64_t>(which.size()) <= group.lanes());
    for (std::int64_t first = 0; first < group.lanes(); first += kLanes) {
        const std::size_t begin = std::min(at(first), which.size());
        const std::span<const int> some =
            which.subspan(begin, std::min<std::size_t>(kLanes, which.size() - begin));
        group.choose(first, some);
        if (threads == GatherThreads::one) {
            group.move(0, vertices);
        } else {
            const Chunks chunks{vertices, kChunk};
            parallel_for(chunks.count(),
                         [&](std::int64_t i) { group.move(chunks.begin(i), chunks.end(i)); });
        }
        for (const int shape : some) features.shapes.forget(shape);
    }
}

template void gather_lanes(const ScaledFeatures&, std::span<const int>, const VertexOrder&,
                           std::span<float>, GatherThreads);
template void gather_lanes(const ScaledFeatures&, std::span<const int>, const VertexOrder&,
                           std::span<double>, GatherThreads);

}  // namespace mscomp::nn

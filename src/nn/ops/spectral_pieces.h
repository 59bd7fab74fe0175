// SPDX-License-Identifier: MIT
// What the small and the fused ops of the spectral VAE share: pieces of vertices that stay in
// cache, and sums over them in a fixed order.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "../kernels/spectral_kernels.h"
#include "base/aligned.h"
#include "batch.h"
#include "mscomp/base/index.h"
#include "nn/tape.h"

namespace mscomp::nn {

/// Vertices whose rows stay in the first cache while several kernels go over them.
inline constexpr int kPiece = 16;
/// Codes behind each other in the transposed layout: a multiple of the widest vector.
inline constexpr int kCodePadding = 16;
/// Highest order of a Chebyshev convolution of the fused ops.
inline constexpr int kMostTerms = 16;

/// Extents of C (1,K,V,d') and of what it is multiplied with.
struct LatentSize {
    int components, channels, lanes;
    std::int64_t vertices;

    std::int64_t stride() const { return vertices * channels; }
    std::int64_t codes() const { return std::int64_t{components} * lanes; }
    int padded() const { return (components + kCodePadding - 1) / kCodePadding * kCodePadding; }
};

/// `by_lanes`: rows or codes, whose last extent is the lanes.
template <class T>
LatentSize latent_size(const Tape<T>& tape, Var weights, Var by_lanes) {
    const Extents& extents = tape.extents(weights);
    return {static_cast<int>(extents[1]), static_cast<int>(extents[3]),
            static_cast<int>(tape.extents(by_lanes).back()), extents[2]};
}

/// Calls body(begin, count) for the pieces of [begin, end).
template <class Body>
void for_each_piece(int begin, int end, Body&& body) {
    for (int v = begin; v < end; v += kPiece) body(v, std::min(kPiece, end - v));
}

/// The rows that the piece behind vertices [v, v + count) needs of up to four arrays.
template <class T>
class NextPiece {
  public:
    NextPiece(std::int64_t row, std::int64_t vertices, int v, int count)
        : first_((v + count) * row) {
        ahead_.bytes = std::min<std::int64_t>(kPiece, vertices - v - count) * row *
                       static_cast<std::int64_t>(sizeof(T));
    }
    void add(const T* rows) {
        if (ahead_.count == 4 || ahead_.bytes == 0) return;
        ahead_.pieces[ahead_.count++] = reinterpret_cast<const char*>(rows + first_);
    }
    Ahead& ahead() { return ahead_; }

  private:
    std::int64_t first_;
    Ahead ahead_;
};

/// target[i] += sum of `parts` blocks of `size` numbers, in their order, in double.
template <class T>
void add_blocks(const AlignedVector<T>& blocks, std::int64_t parts, std::int64_t size, T* target) {
    const Chunks pieces{size, 512};
    parallel_for(pieces.count(), [&](std::int64_t piece) {
        std::array<double, 512> sums{};
        const std::int64_t first = pieces.begin(piece), count = pieces.end(piece) - first;
        for (std::int64_t p = 0; p < parts; ++p) {
            const T* block = blocks.data() + p * size + first;
            for (std::int64_t i = 0; i < count; ++i) {
                sums[at(i)] += static_cast<double>(block[i]);
            }
        }
        for (std::int64_t i = 0; i < count; ++i) {
            target[first + i] += static_cast<T>(sums[at(i)]);
        }
    });
}

/// codes (K,lanes) -> (lanes,padded), the padding 0.
template <class T>
void transpose_codes(const LatentSize& size, const T* codes, AlignedVector<T>& transposed) {
    transposed.assign(at(size.lanes) * at(size.padded()), T{0});
    for (int k = 0; k < size.components; ++k) {
        for (int l = 0; l < size.lanes; ++l) {
            transposed[at(l * size.padded() + k)] = codes[std::int64_t{k} * size.lanes + l];
        }
    }
}

/// codes (K,lanes) += C rows, through partial sums per vertex chunk.
template <class T>
void add_codes(const LatentSize& size, const T* weights, const T* rows, AlignedVector<T>& partials,
               T* codes) {
    const std::int64_t chunks = chunk_count(size.vertices);
    partials.assign(at(chunks * size.codes()), T{0});
    for_each_chunk(1, size.vertices, [&](std::int64_t, std::int64_t chunk, int begin, int end) {
        Ahead ahead;
        for_each_piece(begin, end, [&](int v, int count) {
            spectral_kernels<T>().project(
                weights + std::int64_t{v} * size.channels, size.stride(), size.components,
                rows + std::int64_t{v} * size.channels * size.lanes, size.lanes,
                count * size.channels, ahead, partials.data() + chunk * size.codes());
        });
    });
    add_blocks(partials, chunks, size.codes(), codes);
}

/// rows (+)= C^T codes.
template <class T>
void expand_all(const LatentSize& size, const T* weights, const T* codes, bool accumulate,
                T* rows) {
    for_each_chunk(1, size.vertices, [&](std::int64_t, std::int64_t, int begin, int end) {
        Ahead ahead;
        spectral_kernels<T>().expand(weights + std::int64_t{begin} * size.channels, size.stride(),
                                     size.components, codes, size.lanes,
                                     (end - begin) * size.channels, accumulate, ahead,
                                     rows + std::int64_t{begin} * size.channels * size.lanes);
    });
}

/// weights_grad[k][i] += sum over lanes of codes[k] rows[i].
template <class T>
void add_weight_gradient(const LatentSize& size, const T* codes, const T* rows, T* weights_grad) {
    AlignedVector<T> transposed;
    transpose_codes(size, codes, transposed);
    for_each_chunk(1, size.vertices, [&](std::int64_t, std::int64_t, int begin, int end) {
        AlignedVector<T> scratch(at(kPiece * size.channels * size.padded()));
        for_each_piece(begin, end, [&](int v, int count) {
            const std::int64_t first = std::int64_t{v} * size.channels;
            spectral_kernels<T>().outer(transposed.data(), size.padded(), size.components,
                                        rows + first * size.lanes, size.lanes, size.lanes,
                                        count * size.channels, scratch.data(), size.stride(),
                                        weights_grad + first);
        });
    });
}

}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "mscomp/base/parallel.h"
#include "nn/tape.h"

namespace mscomp::nn {

/// Vertices per task. Fixed, so that partial sums do not depend on the number of threads.
inline constexpr std::int64_t kVertexChunk = 128;

/// Calls body(autoencoder, chunk, begin, end) for every autoencoder and vertex chunk, in parallel.
template <class Body>
void for_each_chunk(std::int64_t autoencoders, std::int64_t vertices, Body&& body) {
    const Chunks chunks{vertices, kVertexChunk};
    parallel_for(autoencoders * chunks.count(), [&](std::int64_t task) {
        const std::int64_t chunk = task % chunks.count();
        body(task / chunks.count(), chunk, static_cast<int>(chunks.begin(chunk)),
             static_cast<int>(chunks.end(chunk)));
    });
}

inline std::int64_t chunk_count(std::int64_t vertices) {
    return Chunks{vertices, kVertexChunk}.count();
}

/// target[i] += sum over `parts` consecutive blocks of `size` values, in their order, in double.
template <class T>
void add_partials(const T* partials, std::int64_t parts, std::int64_t size, T* target) {
    for (std::int64_t i = 0; i < size; ++i) {
        double sum = 0;
        for (std::int64_t p = 0; p < parts; ++p) sum += static_cast<double>(partials[p * size + i]);
        target[i] += static_cast<T>(sum);
    }
}

/// Makes an op, records it and returns its output.
template <class Made, class T, class... Arguments>
Var record_op(Tape<T>& tape, Arguments&&... arguments) {
    auto op = std::make_unique<Made>(tape, std::forward<Arguments>(arguments)...);
    const Var made = op->output();
    tape.record(std::move(op));
    return made;
}

}  // namespace mscomp::nn

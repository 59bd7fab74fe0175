// SPDX-License-Identifier: MIT
// What the generated sequences share: their size, names and weights.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "mscomp/generate/generate.h"

namespace mscomp {

/// One component: its name, scale (0 = coarse, 1 = fine), and where its weight swings: between
/// `lowest_weight` and 1.
struct Mover {
    const char* name;
    int scale;
    double lowest_weight;
};

/// Throws UsageError if frames < 2 or vertices < 100.
void require_size(std::string_view generator, int frames, int vertices);

/// N, K, names, scales and weights (N,K), no shapes and supports yet. Component k swings at a whole
/// number of periods of its own over the frames after the first, which makes all of them orthogonal
/// (N > 2 K + 1); the coarse ones, which come first, take the slow half.
GeneratedSequence still_sequence(const std::vector<Mover>& movers, int frames, std::uint64_t seed);

}  // namespace mscomp

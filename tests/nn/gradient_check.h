// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "nn/tape.h"

namespace mscomp::nn {

inline constexpr double kUnitRoundoff = 6e-8;  // of float

/// Result of comparing hand-written gradients with finite differences.
struct GradientReport {
    double worst_error = 0;  // relative to the larger of the two and 1e-2 of the largest
    std::string where;       // "w_own[17]: backward 0.3, differences 0.2"
    /// False for NaN too.
    bool within(double tolerance) const { return worst_error <= tolerance; }
};

/// Compares backward with four-point differences of sum_i w_i output_i, w random, over every
/// element of `inputs`, or over `samples` elements spread over each. Records the sum on the tape,
/// so call it once per tape.
GradientReport check_gradients(Tape<double>& tape, Var output, const std::vector<Var>& inputs,
                               std::size_t samples = std::numeric_limits<std::size_t>::max());

/// Fills a value with numbers of CounterRandom, normal times `scale`.
template <class T>
void fill_random(Tape<T>& tape, Var var, std::uint64_t stream, double scale = 1.0);

}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
#include "polar_lanes.h"

#include <math.h>

#include "mscomp/base/vector_widths.h"

namespace mscomp {
namespace {

// Below this determinant of T / max|T_ij| the iteration is left for the slower, safer SVD.
constexpr double kWellConditioned = 1e-3;
// Of max|T_ij|: its reciprocal is finite.
constexpr double kSmallest = 1e-300;
// Three scaled steps bring every condition that is let in near 1; then g would be 1.
constexpr int kScaledSteps = 3, kMostSteps = 30;
// Convergence is quadratic: a squared step of 1e-16 leaves an error of rounding size.
constexpr double kConverged = 1e-16;

/// X = T / max|T_ij|, the identity in lanes that are not solved.
template <int kLanes>
[[gnu::always_inline]] inline void start(PolarLanes<kLanes>& lanes) {
    const auto& t = lanes.gradient;
    auto& x = lanes.rotation;
#pragma omp simd
    for (int l = 0; l < kLanes; ++l) {
        double size = 0;
        for (int k = 0; k < 9; ++k) {
            const double entry = t[k][l] < 0 ? -t[k][l] : t[k][l];
            size = entry > size ? entry : size;
        }
        const double factor = 1 / size;
        double scaled[9];
        for (int k = 0; k < 9; ++k) scaled[k] = factor * t[k][l];
        const double determinant = scaled[0] * (scaled[4] * scaled[8] - scaled[5] * scaled[7]) +
                                   scaled[1] * (scaled[5] * scaled[6] - scaled[3] * scaled[8]) +
                                   scaled[2] * (scaled[3] * scaled[7] - scaled[4] * scaled[6]);
        const double is_regular = determinant > kWellConditioned ? 1.0 : 0.0;
        const double solved = size > kSmallest ? is_regular : 0.0;
        lanes.solved[l] = solved;
        for (int k = 0; k < 9; ++k) {
            const double identity = k % 4 == 0 ? 1.0 : 0.0;
            x[k][l] = solved > 0 ? scaled[k] : identity;
        }
    }
}

/// One step in the lanes where `open` is 1, which becomes 0 where that was the last.
template <int kLanes, bool kScaled>
[[gnu::always_inline]] inline void step(double (&x)[9][kLanes], double (&open)[kLanes]) {
#pragma omp simd
    for (int l = 0; l < kLanes; ++l) {
        const double x0 = x[0][l], x1 = x[1][l], x2 = x[2][l];
        const double x3 = x[3][l], x4 = x[4][l], x5 = x[5][l];
        const double x6 = x[6][l], x7 = x[7][l], x8 = x[8][l];
        // Cofactors: det X times X^-T.
        const double c0 = x4 * x8 - x5 * x7, c1 = x5 * x6 - x3 * x8, c2 = x3 * x7 - x4 * x6;
        const double c3 = x2 * x7 - x1 * x8, c4 = x0 * x8 - x2 * x6, c5 = x1 * x6 - x0 * x7;
        const double c6 = x1 * x5 - x2 * x4, c7 = x2 * x3 - x0 * x5, c8 = x0 * x4 - x1 * x3;
        const double determinant = x0 * c0 + x1 * c1 + x2 * c2;
        double from = 0.5, to = 0.5 / determinant;
        if constexpr (kScaled) {
            const double xx = x0 * x0 + x1 * x1 + x2 * x2 + x3 * x3 + x4 * x4 + x5 * x5 + x6 * x6 +
                              x7 * x7 + x8 * x8;
            const double cc = c0 * c0 + c1 * c1 + c2 * c2 + c3 * c3 + c4 * c4 + c5 * c5 + c6 * c6 +
                              c7 * c7 + c8 * c8;
            // g² = |X^-T| / |X|.
            const double g = sqrt(sqrt(cc / (xx * determinant * determinant)));
            from = 0.5 * g;
            to = 0.5 / (g * determinant);
        }
        // Where the lane has converged, the step is X <- 1 X + 0 X^-T, with no branch.
        from = open[l] * from + (1 - open[l]);
        to = open[l] * to;
        const double last[9] = {x0, x1, x2, x3, x4, x5, x6, x7, x8};
        const double cofactors[9] = {c0, c1, c2, c3, c4, c5, c6, c7, c8};
        double change = 0;
        for (int k = 0; k < 9; ++k) {
            const double next = from * last[k] + to * cofactors[k];
            change += (next - last[k]) * (next - last[k]);
            x[k][l] = next;
        }
        open[l] = change < kConverged ? 0.0 : 1.0;
    }
}

template <int kLanes>
[[gnu::always_inline]] inline bool any(const double (&open)[kLanes]) {
    double sum = 0;
    for (int l = 0; l < kLanes; ++l) sum += open[l];
    return sum > 0;
}

template <int kLanes>
[[gnu::always_inline]] inline void iterate(PolarLanes<kLanes>& lanes) {
    alignas(64) double open[kLanes];
    for (int l = 0; l < kLanes; ++l) open[l] = lanes.solved[l];
    for (int i = 0; i < kScaledSteps && any(open); ++i) step<kLanes, true>(lanes.rotation, open);
    for (int i = kScaledSteps; i < kMostSteps && any(open); ++i) {
        step<kLanes, false>(lanes.rotation, open);
    }
}

/// S = (Rᵀ T + Tᵀ R) / 2.
template <int kLanes>
[[gnu::always_inline]] inline void multiply(PolarLanes<kLanes>& lanes) {
    const auto& r = lanes.rotation;
    const auto& t = lanes.gradient;
    int entry = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j, ++entry) {
#pragma omp simd
            for (int l = 0; l < kLanes; ++l) {
                const double ij = r[3 * i][l] * t[3 * j][l] + r[3 * i + 1][l] * t[3 * j + 1][l] +
                                  r[3 * i + 2][l] * t[3 * j + 2][l];
                const double ji = r[3 * j][l] * t[3 * i][l] + r[3 * j + 1][l] * t[3 * i + 1][l] +
                                  r[3 * j + 2][l] * t[3 * i + 2][l];
                lanes.stretch[entry][l] = 0.5 * (ij + ji);
            }
        }
    }
}

}  // namespace

template <>
void decompose<1>(PolarLanes<1>& lanes) {
    start(lanes);
    iterate(lanes);
    multiply(lanes);
}

template <>
MSCOMP_FOR_EACH_VECTOR_WIDTH void decompose<16>(PolarLanes<16>& lanes) {
    start(lanes);
    iterate(lanes);
    multiply(lanes);
}

}  // namespace mscomp

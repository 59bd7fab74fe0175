// SPDX-License-Identifier: MIT
#pragma once

namespace mscomp {

/// Several 3x3 matrices side by side, entry by entry: [entry][lane], entries column by column.
template <int kLanes>
struct PolarLanes {
    alignas(64) double gradient[9][kLanes];  // in
    alignas(64) double rotation[9][kLanes];  // out, as are all below
    alignas(64) double stretch[6][kLanes];   // S11 S12 S13 S22 S23 S33
    alignas(64) double solved[kLanes];       // 0: left to a method that can do it, 1: solved
};

/// Where entry k of a full symmetric matrix stands among its six different ones.
inline constexpr int kSymmetricEntry[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5};

/// T = R S by Newton's iteration X <- (g X + X^-T / g) / 2, Higham's scaling g in its first steps,
/// where T is proper and well away from singular. Each lane keeps its result when it has converged,
/// so its bits depend on nothing but its own matrix; compiled without contraction of products and
/// sums, the same bits come from every instruction set. Defined for 1 and 16 lanes.
template <int kLanes>
void decompose(PolarLanes<kLanes>& lanes);

}  // namespace mscomp

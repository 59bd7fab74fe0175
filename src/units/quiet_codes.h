// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

namespace mscomp {

/// Shapes along the directions in which they differ most.
struct ShapeBasis {
    Eigen::MatrixXd places;  // (N,r), of mean square 1 in each direction
    Eigen::VectorXd sizes;   // (r) singular values, falling
    double size = 0;         // root of the sum of the squares of all of them
};

/// Of the inner products (N,N) of all pairs of shapes; at most `most` directions, those only that
/// are more than rounding.
ShapeBasis shape_basis(const Eigen::MatrixXd& gram, int most);

/// Said where a search of minutes is stopped: it keeps nothing of what it has found so far.
inline constexpr const char* kSearchInterrupted =
    "interrupted while units were looked for; the same command begins anew";

/// The w that minimises Σ_i φ(|Y_i w|) where here · w = 1, Y_i being `width` rows of `places` one
/// after the other, by reweighting (method §10): φ grows like the root of its argument, measured
/// against the largest of them. `damping` (r) is what w costs by itself.
struct QuietSearch {
    const Eigen::MatrixXd& places;  // (width n,r)
    int width = 1;
    Eigen::VectorXd damping;
    int rounds = 5;  // at each of five lengths that count as near zero
    /// How much more the numbers below zero count, where the width is 1.
    double below_zero = 1;
};
struct QuietReadout {
    Eigen::VectorXd weights;  // w
    Eigen::VectorXd sizes;    // (n) |Y_i w|, the largest 1; of width 1 with their sign
    double loudness = 0;      // Σ_i φ at the end
};
/// For each `here`, columns (r,M). Throws Interrupted.
std::vector<QuietReadout> quiet_readouts(const QuietSearch& search, const Eigen::MatrixXd& here);

/// Codes (N,M) of linear read-outs, each as quiet as possible at all shapes but one (method §10,
/// code route, step 2): for every shape that is not the reference, in their order, the w that
/// minimises Σ_n φ((Y w)_n) with (Y w) = 1 at that shape, by reweighting; φ grows like the root of
/// its argument, ten times as fast below zero. `noise`: the size of what is no movement, as a part
/// of all. The largest |code| of each column is 1. The same bits for any number of threads.
Eigen::MatrixXd quiet_codes(const ShapeBasis& basis, double noise);

}  // namespace mscomp

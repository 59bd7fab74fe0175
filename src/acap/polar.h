// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>

namespace mscomp {

struct PolarDecomposition {
    Eigen::Matrix3d rotation;  // orthogonal, det +1
    Eigen::Matrix3d stretch;   // symmetric; positive semidefinite unless mirrored
    bool mirrored = false;     // det T < 0: the smallest eigenvalue of the stretch is negative
};

/// T = R S with R the proper rotation nearest to T. Finite for every finite T, singular and zero
/// included.
PolarDecomposition polar_decomposition(const Eigen::Matrix3d& gradient);

/// The same of as many as there are `results`, several at a time: the same bits for each as if it
/// stood alone, whatever stands beside it and whatever vectors the processor has.
void polar_decompositions(std::span<const Eigen::Matrix3d> gradients,
                          std::span<PolarDecomposition> results);

}  // namespace mscomp

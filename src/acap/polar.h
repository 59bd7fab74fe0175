// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace mscomp {

struct PolarDecomposition {
    Eigen::Matrix3d rotation;  // orthogonal, det +1
    Eigen::Matrix3d stretch;   // symmetric; positive semidefinite unless mirrored
    bool mirrored = false;     // det T < 0: the smallest eigenvalue of the stretch is negative
};

/// T = R S with R the proper rotation nearest to T. Finite for every finite T, singular and zero
/// included.
PolarDecomposition polar_decomposition(const Eigen::Matrix3d& gradient);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Normal equations of min over dz, w, t of |J dz + w x p + t + r|² with the rigid motion (w, t)
/// eliminated: H dz = -g.
struct NormalEquations {
    Eigen::MatrixXd H;  // (K,K) symmetric
    Eigen::VectorXd g;  // (K) Jᵀ r
};

/// `derivatives` is J (K,V,3), `residuals` r (V) at the `positions` p (V) that fit best among all
/// rigid motions of them.
NormalEquations reduced_normal_equations(std::span<const double> derivatives,
                                         const std::vector<Point>& positions,
                                         const std::vector<Point>& residuals);

/// K + 1 residuals that stand for many: their sum of squares, gradient and normal matrix are those
/// of the normal equations. With Rᵀ R = H they are R⁻ᵀ g and, not depending on z, what is missing
/// of the sum of squares, sqrt(|r|² - |R⁻ᵀ g|²).
struct SmallResiduals {
    Eigen::VectorXd values;      // (K+1)
    Eigen::MatrixXd derivative;  // (K+1,K) R and a row of zeros
};

/// `squares` is |r|². H may be singular: g has no part where H has none.
SmallResiduals small_residuals(const NormalEquations& equations, double squares);

}  // namespace mscomp

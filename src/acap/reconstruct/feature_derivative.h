// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "acap/rotation.h"

namespace mscomp {

/// T = exp(r) S at one feature, its derivative and the adjoint of that. Accurate near r = 0 and of
/// any length of r.
struct FeatureDerivative {
    explicit FeatureDerivative(const Feature& feature);

    /// dT = [J_l(r) dr]x T + exp(r) dS.
    Eigen::Matrix3d change(const Feature& direction) const;
    /// dE/d(r, S) from dE/dT, so that <dE/dT, change(d)> = <adjoint(dE/dT), d>: a channel beside
    /// the diagonal stands for two entries of S.
    Feature adjoint(const Eigen::Matrix3d& by_gradient) const;

    Eigen::Matrix3d rotation, gradient, left_jacobian;
};

}  // namespace mscomp

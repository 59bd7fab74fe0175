// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "acap/rotation.h"

namespace mscomp {

/// T = exp(r) S at one feature and its derivative. Accurate near r = 0 and of any length of r.
struct FeatureDerivative {
    explicit FeatureDerivative(const Feature& feature);

    /// dT = [J_l(r) dr]x T + exp(r) dS.
    Eigen::Matrix3d change(const Feature& direction) const;

    Eigen::Matrix3d rotation, gradient, left_jacobian;
};

}  // namespace mscomp

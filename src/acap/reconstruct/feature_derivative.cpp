// SPDX-License-Identifier: MIT
#include "feature_derivative.h"

namespace mscomp {

FeatureDerivative::FeatureDerivative(const Feature& feature)
    : rotation(rotation_exp(feature.head<3>())),
      gradient(rotation * stretch_of_feature(feature)),
      left_jacobian(rotation_left_jacobian(feature.head<3>())) {}

Eigen::Matrix3d FeatureDerivative::change(const Feature& direction) const {
    const Eigen::Vector3d turn = left_jacobian * direction.head<3>();
    Eigen::Matrix3d by_turn;
    by_turn << 0, -turn.z(), turn.y(),  //
        turn.z(), 0, -turn.x(),         //
        -turn.y(), turn.x(), 0;
    return by_turn * gradient + rotation * stretch_of_feature(direction);
}

}  // namespace mscomp

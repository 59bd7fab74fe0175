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

Feature FeatureDerivative::adjoint(const Eigen::Matrix3d& by_gradient) const {
    // <G, [w]x T> = <G Tᵀ, [w]x>
    const Eigen::Matrix3d by_cross = by_gradient * gradient.transpose();
    const Eigen::Vector3d by_turn(by_cross(2, 1) - by_cross(1, 2), by_cross(0, 2) - by_cross(2, 0),
                                  by_cross(1, 0) - by_cross(0, 1));
    const Eigen::Matrix3d by_stretch = rotation.transpose() * by_gradient;
    Feature result;
    result << left_jacobian.transpose() * by_turn,  //
        by_stretch(0, 0), by_stretch(0, 1) + by_stretch(1, 0), by_stretch(0, 2) + by_stretch(2, 0),
        by_stretch(1, 1), by_stretch(1, 2) + by_stretch(2, 1), by_stretch(2, 2);
    return result;
}

}  // namespace mscomp

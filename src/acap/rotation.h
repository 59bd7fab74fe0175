// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

namespace mscomp {

/// Rotation by |r| radians about r: exp of the skew matrix of r. Exact near r = 0 and of any
/// length.
Eigen::Matrix3d rotation_exp(const Eigen::Vector3d& rotation_vector);

/// Left Jacobian of the exponential at r: exp(r + dr) = exp(J_l(r) dr) exp(r) to first order in dr.
/// Accurate near r = 0 and of any length.
Eigen::Matrix3d rotation_left_jacobian(const Eigen::Vector3d& rotation_vector);

/// Principal logarithm of a proper rotation, length in [0, π], through the unit quaternion, hence
/// accurate near 0 and near π; at π the sign of the axis is arbitrary.
Eigen::Vector3d rotation_log(const Eigen::Matrix3d& rotation);

/// One ACAP feature: r, then the upper triangle of S row by row.
using Feature = Eigen::Matrix<double, 9, 1>;

/// S of a feature.
Eigen::Matrix3d stretch_of_feature(const Feature& feature);

/// T = exp(r) S of a feature.
Eigen::Matrix3d gradient_of_feature(const Feature& feature);

/// The same for all vertices of a shape. Throws MeshError unless there are `vertex_count` x 9
/// values, NumericalError if one of them is not finite.
std::vector<Eigen::Matrix3d> gradients_of_features(std::span<const float> features,
                                                   std::size_t vertex_count);

}  // namespace mscomp

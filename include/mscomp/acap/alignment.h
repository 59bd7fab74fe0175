// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Mean of at least one point.
Point mean_point(std::span<const Point> points);

struct RigidMotion {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

/// The rigid motion (det +1, no scale) that minimises Σ |R p_i + t - q_i|² (Procrustes).
RigidMotion best_rigid_motion(const std::vector<Point>& points, const std::vector<Point>& target);

/// The rigid motion after which what rests lies still, whatever the others do: lowers Σ φ(|R p_i +
/// t
/// - q_i|), φ growing like the root of its argument, by reweighting (30 weighted Procrustes
/// problems) from the best motion. Of points that all move it is one of many that bring some of
/// them home.
RigidMotion resting_motion(const std::vector<Point>& points, const std::vector<Point>& target);

std::vector<Point> moved(const std::vector<Point>& points, const RigidMotion& motion);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/acap/alignment.h"

#include "edge_weights.h"
#include "polar.h"

namespace mscomp {
namespace {

Eigen::Vector3d centroid(const std::vector<Point>& points) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Point& point : points) sum += as_vector(point);
    return sum / static_cast<double>(points.size());
}

}  // namespace

RigidMotion best_rigid_motion(const std::vector<Point>& points, const std::vector<Point>& target) {
    const Eigen::Vector3d from = centroid(points), to = centroid(target);
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
        covariance += (as_vector(target[i]) - to) * (as_vector(points[i]) - from).transpose();
    }
    RigidMotion motion;
    // max tr(Rᵀ C) over proper rotations is the rotation nearest to C.
    motion.rotation = polar_decomposition(covariance).rotation;
    motion.translation = to - motion.rotation * from;
    return motion;
}

std::vector<Point> moved(const std::vector<Point>& points, const RigidMotion& motion) {
    std::vector<Point> result(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        Eigen::Map<Eigen::Vector3d>(result[i].data()) =
            motion.rotation * as_vector(points[i]) + motion.translation;
    }
    return result;
}

}  // namespace mscomp

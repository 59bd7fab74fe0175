// SPDX-License-Identifier: MIT
#include "mscomp/acap/alignment.h"

#include "edge_weights.h"
#include "polar.h"

namespace mscomp {
namespace {

Eigen::Vector3d mean_vector(const std::vector<Point>& points) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Point& point : points) sum += as_vector(point);
    return sum / static_cast<double>(points.size());
}

}  // namespace

Point mean_point(std::span<const Point> points) {
    Point sum{};
    for (const Point& point : points) {
        for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += point[axis];
    }
    for (double& x : sum) x /= static_cast<double>(points.size());
    return sum;
}

RigidMotion best_rigid_motion(const std::vector<Point>& points, const std::vector<Point>& target) {
    const Eigen::Vector3d from = mean_vector(points), to = mean_vector(target);
    // Columns apart: the compiler then keeps them in registers.
    Eigen::Vector3d first = Eigen::Vector3d::Zero(), second = first, third = first;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3d goal = as_vector(target[i]) - to;
        first += (points[i][0] - from.x()) * goal;
        second += (points[i][1] - from.y()) * goal;
        third += (points[i][2] - from.z()) * goal;
    }
    Eigen::Matrix3d covariance;
    covariance << first, second, third;
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

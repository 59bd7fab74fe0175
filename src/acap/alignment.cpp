// SPDX-License-Identifier: MIT
#include "mscomp/acap/alignment.h"

#include <cmath>
#include <numeric>

#include "edge_weights.h"
#include "polar.h"

namespace mscomp {
namespace {

/// `weights` sum to 1; none: all the same.
Eigen::Vector3d mean_vector(const std::vector<Point>& points, const std::vector<double>& weights) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    if (weights.empty()) {
        for (const Point& point : points) sum += as_vector(point);
        return sum / static_cast<double>(points.size());
    }
    for (std::size_t i = 0; i < points.size(); ++i) sum += weights[i] * as_vector(points[i]);
    return sum;
}

/// The best one of points that count as much as `weights` say.
RigidMotion weighted_motion(const std::vector<Point>& points, const std::vector<Point>& target,
                            const std::vector<double>& weights) {
    const Eigen::Vector3d from = mean_vector(points, weights), to = mean_vector(target, weights);
    // Columns apart: the compiler then keeps them in registers.
    Eigen::Vector3d first = Eigen::Vector3d::Zero(), second = first, third = first;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3d away = as_vector(target[i]) - to;
        const Eigen::Vector3d goal = weights.empty() ? away : weights[i] * away;
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

/// Squares of the distances that are left.
std::vector<double> squares_left(const std::vector<Point>& points, const RigidMotion& motion,
                                 const std::vector<Point>& target) {
    std::vector<double> squares(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        squares[i] =
            (motion.rotation * as_vector(points[i]) + motion.translation - as_vector(target[i]))
                .squaredNorm();
    }
    return squares;
}

/// (d² + near²)^(-3/4), which sum to 1.
std::vector<double> weights_of(const std::vector<double>& squares, double near_square) {
    std::vector<double> weights(squares.size());
    double sum = 0;
    for (std::size_t i = 0; i < squares.size(); ++i) {
        const double root = std::sqrt(squares[i] + near_square);
        weights[i] = 1 / (root * std::sqrt(root));
        sum += weights[i];
    }
    for (double& weight : weights) weight /= sum;
    return weights;
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
    return weighted_motion(points, target, {});
}

RigidMotion resting_motion(const std::vector<Point>& points, const std::vector<Point>& target) {
    // What is near beside the mean distance, smaller and smaller, and rounds with each.
    constexpr double kNear[] = {1, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001};
    constexpr int kRounds = 3;
    RigidMotion motion = best_rigid_motion(points, target);
    std::vector<double> squares = squares_left(points, motion, target);
    const double mean =
        std::accumulate(squares.begin(), squares.end(), 0.0) / static_cast<double>(squares.size());
    if (!(mean > 0)) return motion;
    for (const double near : kNear) {
        for (int round = 0; round < kRounds; ++round) {
            motion = weighted_motion(points, target, weights_of(squares, near * near * mean));
            squares = squares_left(points, motion, target);
        }
    }
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

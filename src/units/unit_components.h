// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"

namespace mscomp {

/// Inner products (N,N) of all pairs of shapes.
Eigen::MatrixXd gram_of_shapes(const MetricRows& rows);

/// What of its greatest length a component is at least where it acts.
inline constexpr double kLeastLength = 0.05;

/// Components (method §10, code route, step 6) by least squares on fixed codes (N,K): zero where
/// they are below `least` of their greatest length, fitted once more at every vertex to what is
/// left there. A centre is where a component is longest; codes are then those of components as they
/// come.
BallComponents unit_components(const MetricRows& rows, const Eigen::MatrixXd& codes,
                               double least = kLeastLength);

/// Components where balls say, by least squares on fixed codes (N,K) at every vertex.
BallComponents fitted_components(const MetricRows& rows, const Eigen::MatrixXd& codes,
                                 std::vector<Ball> balls);

/// What joint codes leave of the squares of a shape, mean over the shapes.
double squares_left(const MetricRows& rows, const BallComponents& components);

/// How much of the squares of all shapes each unit moves, (K).
std::vector<double> movements(const BallComponents& components, const Eigen::MatrixXd& codes);

/// All units, those that move the shapes most first.
std::vector<int> most_moving_first(const std::vector<double>& movements);

/// Units in the order in which they are kept, and how many of them are on each level: those that
/// move much of the mesh before those that move little of it, where there are two scales, that is
/// where the sorted supports (K), in vertices, jump by half or more with two units and a fifth at
/// least on both sides; within a level those that move most come first.
struct UnitOrder {
    std::vector<int> units;
    std::vector<int> levels;
};
UnitOrder order_of_units(const std::vector<double>& movements, const std::vector<int>& supports);

}  // namespace mscomp

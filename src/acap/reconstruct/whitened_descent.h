// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "anchored_system.h"

namespace mscomp {

/// A function of positions (V) that fills in its derivative (V) and returns its value.
using PositionFunction = std::function<double(const std::vector<Point>&, std::vector<Point>&)>;

struct DescentOptions {
    int memory = 8;             // pairs of steps and changes of the derivative that are kept
    int max_evaluations = 100;  // of the function
    double largest_step = 0;    // converged when a step moves no coordinate by more,
    double least_gain = 3e-6;   // or when it lowers the value by a smaller share of it
};

struct DescentResult {
    double value = 0;
    int steps = 0;
    bool converged = false;
};

/// Lowers f, a sum of squares, from `positions` by L-BFGS steps of Ceres (GradientProblemSolver) in
/// the whitened variables y = Cᵀ x of `metric` A = C Cᵀ, about half the Hessian of f: there the
/// first guess of the inverse Hessian, the identity, is ½ A⁻¹. The anchors of the metric stay. The
/// value never rises, and the result is the lowest point that was looked at.
DescentResult descend(const PositionFunction& f, const AnchoredSystem& metric,
                      std::vector<Point>& positions, const DescentOptions& options);

}  // namespace mscomp

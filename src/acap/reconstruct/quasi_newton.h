// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>

namespace mscomp {

struct QuasiNewtonOptions {
    int memory = 8;             // pairs of steps and changes of the derivative that are kept
    int max_evaluations = 100;  // of the function
    double largest_step = 0;    // converged when no entry of x moves by more,
    double least_gain = 1e-6;   // or when a step lowers the value by a smaller share of it,
    double least_value = -std::numeric_limits<double>::infinity();  // or where it is no larger
};

struct QuasiNewtonResult {
    double value = 0;
    int steps = 0;
    bool converged = false;
};

/// Lowers f from `x` by L-BFGS steps whose first guess of the inverse Hessian is `precondition`
/// (linear, symmetric positive definite). The value never rises. f(x, derivative) returns the
/// value.
QuasiNewtonResult minimize(
    const std::function<double(const Eigen::VectorXd&, Eigen::VectorXd&)>& f,
    const std::function<Eigen::VectorXd(const Eigen::VectorXd&)>& precondition, Eigen::VectorXd& x,
    const QuasiNewtonOptions& options);

}  // namespace mscomp

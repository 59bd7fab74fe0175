// SPDX-License-Identifier: MIT
#include "quasi_newton.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

using Eigen::VectorXd;

constexpr double kSufficientDecrease = 1e-4;  // Armijo
constexpr int kMaxHalvings = 12;

/// A step, the change of the derivative along it, and 1 / (step · change).
struct Pair {
    VectorXd step, change;
    double inverse_product;
};

/// H g by the two loops over the kept pairs (Nocedal).
VectorXd inverse_hessian_times(const VectorXd& derivative, const std::deque<Pair>& pairs,
                               const std::function<VectorXd(const VectorXd&)>& precondition) {
    VectorXd q = derivative;
    std::vector<double> shares(pairs.size());
    for (std::size_t k = pairs.size(); k-- > 0;) {
        shares[k] = pairs[k].inverse_product * pairs[k].step.dot(q);
        q -= shares[k] * pairs[k].change;
    }
    q = precondition(q);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        q += (shares[k] - pairs[k].inverse_product * pairs[k].change.dot(q)) * pairs[k].step;
    }
    return q;
}

/// The minimum of the parabola through value and slope at 0 and the value at `length`, kept within
/// a tenth and a half of it.
double shorter(double length, double value, double slope, double tried) {
    const double curvature = tried - value - slope * length;
    const double best = curvature > 0 ? -0.5 * slope * length * length / curvature : 0.0;
    return std::clamp(best, 0.1 * length, 0.5 * length);
}

}  // namespace

QuasiNewtonResult minimize(const std::function<double(const VectorXd&, VectorXd&)>& f,
                           const std::function<VectorXd(const VectorXd&)>& precondition,
                           VectorXd& x, const QuasiNewtonOptions& options) {
    QuasiNewtonResult result;
    VectorXd derivative(x.size()), next_derivative(x.size()), next(x.size());
    result.value = f(x, derivative);
    int evaluations = 1;
    std::deque<Pair> pairs;
    while (evaluations < options.max_evaluations) {
        if (result.value <= options.least_value) {
            result.converged = true;
            return result;
        }
        VectorXd step = -inverse_hessian_times(derivative, pairs, precondition);
        double slope = step.dot(derivative);
        if (!(slope < 0)) {
            if (pairs.empty()) return result;  // the derivative is zero to rounding
            pairs.clear();
            continue;
        }
        if (step.cwiseAbs().maxCoeff() <= options.largest_step) {
            result.converged = true;
            return result;
        }
        double length = 1, tried = 0;
        bool found = false;
        for (int halving = 0; halving <= kMaxHalvings && !found; ++halving) {
            next = x + length * step;
            tried = f(next, next_derivative);
            ++evaluations;
            found = tried <= result.value + kSufficientDecrease * length * slope;
            if (!found) length = shorter(length, result.value, slope, tried);
        }
        if (!found) {
            if (pairs.empty()) return result;
            pairs.clear();  // the kept curvature misleads: start anew with the constant matrix
            continue;
        }
        ++result.steps;
        Pair pair{length * step, next_derivative - derivative, 0};
        const double product = pair.step.dot(pair.change);
        if (product > 1e-10 * pair.step.norm() * pair.change.norm()) {
            pair.inverse_product = 1 / product;
            pairs.push_back(std::move(pair));
            if (pairs.size() > at(options.memory)) pairs.pop_front();
        }
        x.swap(next);
        derivative.swap(next_derivative);
        const double gain = result.value - tried;
        result.value = tried;
        if (gain <= options.least_gain * tried) {
            result.converged = true;
            return result;
        }
    }
    return result;
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "code_descent.h"
#include "reduced_normal_equations.h"

namespace mscomp {

/// Codes with everything that follows from them.
struct Trial {
    std::vector<float> codes;
    std::vector<float> features;
    std::vector<Point> positions;  // (V) the centroid of the known ones at 0
    std::vector<Point> known;      // of these the known ones, and
    std::vector<Point> residuals;  // they minus the truth, turned to them
    double error = 0;              // mean square of a coordinate, in the unit ball
    double objective = 0;
};

/// Tries codes for one shape: the objective, and its normal equations over the codes that may move.
class CodeTrials {
  public:
    /// As descend(), whose arguments are borrowed but for `truth` and `start`.
    CodeTrials(const CodeObjective& objective, std::span<const Point> truth,
               std::span<const float> start, const FitSubset& subset);

    /// The start. Throws NumericalError if it decodes to features that are not finite.
    Trial first() const;
    /// `trial` has its codes; false, and nothing else is filled in, if their features are not
    /// finite.
    bool evaluate(Trial& trial) const;
    /// H and g of the objective, the rigid motion eliminated: its gradient is 2 g, and 2 H its
    /// Hessian but for the second derivatives of the positions.
    NormalEquations normal_equations(const Trial& trial) const;

    /// Root-mean-square difference of a known coordinate, in the unit of the mesh.
    double rms(const Trial& trial) const { return std::sqrt(trial.error) / objective_.scale; }
    /// (V) moved to the truth.
    std::vector<Point> placed(const Trial& trial) const;

  private:
    double prior() const;
    double error_scale() const;
    Eigen::VectorXd departure(const std::vector<float>& codes) const;
    std::vector<double> derivatives(const Trial& trial) const;
    void compare(Trial& trial) const;

    const CodeObjective& objective_;
    const FitSubset& subset_;
    std::vector<float> start_;
    std::vector<Point> truth_;   // known vertices, their centroid at 0, and
    Point truth_center_;         // where it was
    Eigen::VectorXd stiffness_;  // of the codes that may move
};

}  // namespace mscomp

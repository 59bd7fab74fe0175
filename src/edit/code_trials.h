// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "reduced_normal_equations.h"

namespace mscomp {

/// Codes with everything that follows from them.
struct Trial {
    std::vector<float> codes;
    std::vector<float> rows;  // what they decode to
    double error = 0;         // mean square difference from the shape
    double objective = 0;

    // Where vertices are fitted:
    std::vector<Point> positions;  // (V) the centroid of the known ones at 0
    std::vector<Point> known;      // of these the known ones, and
    std::vector<Point> residuals;  // they minus the truth, turned to them
};

/// What codes may do for one shape.
struct CodeFreedom {
    std::span<const float> start;  // (K)
    std::span<const int> moving;   // ascending; the others stay at the start
    Eigen::VectorXd stiffness;     // of those that move
    double prior = 0;              // what Σ stiffness_k (z_k - start_k)² counts beside the error
};

/// Tries codes for one shape: the objective, error + prior, and its normal equations over the codes
/// that move. What the error is belongs to who derives.
class CodeTrials {
  public:
    CodeTrials(const CodeTrials&) = delete;
    CodeTrials& operator=(const CodeTrials&) = delete;
    virtual ~CodeTrials() = default;

    /// The start. Throws NumericalError if it decodes to what is not finite.
    Trial first() const;
    /// `trial` has its codes; false, and the objective is not filled in, if what they decode to is
    /// not finite.
    bool evaluate(Trial& trial) const;
    /// H and g of the objective: its gradient is 2 g, and 2 H its Hessian but for the second
    /// derivatives of what codes decode to.
    NormalEquations normal_equations(const Trial& trial) const;

    const CodeFreedom& freedom() const { return freedom_; }

  protected:
    explicit CodeTrials(CodeFreedom freedom) : freedom_(std::move(freedom)) {}

  private:
    virtual std::vector<float> rows(std::span<const float> codes) const = 0;
    /// Fills in what follows from the rows but the objective.
    virtual void compare(Trial& trial) const = 0;
    /// Of the error alone.
    virtual NormalEquations error_equations(const Trial& trial) const = 0;

    Eigen::VectorXd departure(const std::vector<float>& codes) const;

    CodeFreedom freedom_;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "code_trials.h"
#include "mscomp/edit/code_positions.h"
#include "mscomp/edit/vertex_fit.h"

namespace mscomp {

/// |R F(Dec(z)) - P|² scale² / 3V + prior² Σ_k stiffness_k (z_k - start_k)² / K, both F and P with
/// the centroid at 0, R the best rotation.
struct VertexObjective {
    CodePositions codes;
    double scale = 1;           // makes the reference fit the unit ball
    Eigen::VectorXd stiffness;  // (K) 1 / deviation²
    VertexFitOptions options;
};

/// Tries codes for one shape by its vertices. In the normal equations the rigid motion is
/// eliminated.
class VertexTrials final : public CodeTrials {
  public:
    /// `truth` (V) and `start` (K) are finite. Of the subset both lists are filled, ascending: the
    /// sums above are over its vertices and codes, centroids are those of its vertices. Borrows all
    /// but `truth`.
    VertexTrials(const VertexObjective& objective, std::span<const Point> truth,
                 std::span<const float> start, const FitSubset& subset);

    /// Root-mean-square difference of a known coordinate, in the unit of the mesh, of an error.
    double rms(double error) const { return std::sqrt(error) / objective_.scale; }
    /// (V) moved to the truth.
    std::vector<Point> placed(const Trial& trial) const;

  private:
    std::vector<float> rows(std::span<const float> codes) const override;
    void compare(Trial& trial) const override;
    NormalEquations error_equations(const Trial& trial) const override;

    double error_scale() const;
    std::vector<double> derivatives(const Trial& trial) const;

    const VertexObjective& objective_;
    const FitSubset& subset_;
    std::vector<Point> truth_;  // known vertices, their centroid at 0, and
    Point truth_center_;        // where it was
};

}  // namespace mscomp

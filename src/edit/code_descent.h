// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "mscomp/edit/code_positions.h"
#include "mscomp/edit/vertex_fit.h"

namespace mscomp {

/// |R F(Dec(z)) - P|² scale² / 3V + prior² Σ_k stiffness_k (z_k - start_k)² / K, both F and P with
/// the centroid at 0, R the best rotation.
struct CodeObjective {
    CodePositions codes;
    double scale = 1;           // makes the reference fit the unit ball
    Eigen::VectorXd stiffness;  // (K) 1 / deviation²
    VertexFitOptions options;
};

/// Levenberg-Marquardt steps from `start` (K) towards `truth` (V), both finite. Of the subset both
/// lists are filled, ascending: the sums above are over its vertices and codes, centroids are those
/// of its vertices. Throws NumericalError if the start decodes to features that are not finite.
FittedShape descend(const CodeObjective& objective, std::span<const Point> truth,
                    std::span<const float> start, const FitSubset& subset);

}  // namespace mscomp

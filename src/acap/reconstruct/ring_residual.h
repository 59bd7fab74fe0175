// SPDX-License-Identifier: MIT
#pragma once

#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <vector>

#include "feature_equations.h"

namespace mscomp {

/// The constant part of the equations of one vertex, in numbers of its own: 0 is the vertex, 1 ..
/// degree its neighbours.
struct RingShape {
    std::vector<int> members;                   // (degree + 1) vertices
    OneRings rings;                             // only that of 0 has neighbours
    std::vector<Face> faces;                    // around the vertex
    VertexFaces around;                         // only 0 has faces
    std::vector<Eigen::Vector3d> edge_factors;  // (degree) g_ij
    std::vector<Eigen::Vector3d> moments;       // (degree) c_ij e_ij
    Eigen::Vector3d normal_factor;              // g_i
    Eigen::Vector3d reference_normal;           // n_i
    bool reference_folded = false;
};

/// The rings of all vertices (V); those without equations have no members.
std::vector<RingShape> ring_shapes(const FeatureEquations& equations);

/// The nine residuals of one vertex (FeatureEquations), row by row, as a function of the positions
/// of its members, with the derivative of the pseudo-edge. Borrows the ring.
class RingResidual final : public ceres::CostFunction {
  public:
    /// `wanted` is T_i M_i^½.
    RingResidual(const RingShape& ring, const Eigen::Matrix3d& wanted);

    bool Evaluate(double const* const* positions, double* residuals,
                  double** jacobians) const override;

  private:
    const RingShape& ring_;
    Eigen::Matrix3d wanted_;
};

}  // namespace mscomp

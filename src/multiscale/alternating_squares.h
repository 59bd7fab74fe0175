// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/base/metric_scale.h"
#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"

namespace mscomp {

/// Components and codes of least squares in turn (method §9, stage A). What the shapes leave
/// undetermined at a vertex, all of it where there are fewer shapes than components act there, is
/// as at its neighbours.
class AlternatingSquares {
  public:
    /// `damping` is a part of the mean square of a code. Borrows scale.
    AlternatingSquares(OneRings rings, const MetricScale& scale, double damping)
        : rings_(std::move(rings)), scale_(scale), damping_(damping) {}

    /// One round: the joint codes Z of all shapes, then at each vertex v, with G = Σ z zᵀ, A the
    /// components that act there and μ = damping tr G / K, C_v = (G_AA + μ I)⁻¹ (Z_A x_v + μ C̄_v);
    /// then every component has unit length again. C̄_v is the mean over the neighbours before the
    /// round, of features rather than of what they count. Returns the squared error that the codes
    /// had with the components before, mean over the shapes. The same bits for any number of
    /// threads.
    double round(const MetricRows& rows, BallComponents& components) const;

  private:
    struct CodeEquations;
    double fit_vertex(const MetricRows& rows, const CodeEquations& equations,
                      const BallComponents& before, int v, BallComponents& components) const;
    Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor> ring_mean(
        const BallComponents& components, int v) const;

    OneRings rings_;
    const MetricScale& scale_;
    double damping_;
};

}  // namespace mscomp

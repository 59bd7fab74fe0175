// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mscomp/acap/edge_weights.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/model/shape_model.h"

namespace mscomp {

/// What turns features into positions.
enum class VertexSolver { poisson, lossless };
VertexSolver parse_vertex_solver(const std::string& name);  // throws UsageError
std::string to_string(VertexSolver solver);

/// Vertices of what a model decodes to: the one way from rows to meshes. Features are solved for,
/// positions are what they are. Safe to use from several threads.
class RowPositions {
  public:
    /// `weights` and `solver` are for features. Throws what the solvers throw.
    RowPositions(ShapeRows rows, const TriangleMesh& reference, EdgeWeights weights,
                 VertexSolver solver);

    ShapeRows rows() const { return rows_; }
    /// (V). Features do not say where a mesh lies: it gets the centroid of `like` (V), by default
    /// that of the reference, its connected components joined (Pieces::joined): nothing of their
    /// places to each other comes from `like`. Throws NumericalError where `rows` are not finite,
    /// MeshError for another V.
    std::vector<Point> positions(std::span<const float> rows,
                                 std::span<const Point> like = {}) const;
    /// (n,V,3) along n directions at `rows`, the centroid kept where it is; `lossless`: of its
    /// linear part.
    std::vector<double> derivatives(std::span<const float> rows,
                                    std::span<const CodeColumn> directions) const;

  private:
    std::vector<double> position_columns(std::span<const CodeColumn> directions) const;

    ShapeRows rows_;
    std::size_t vertex_count_;
    std::optional<PoissonReconstruction> poisson_;  // of features, one of these
    std::optional<LosslessReconstruction> lossless_;
};

}  // namespace mscomp

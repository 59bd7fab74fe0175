// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "mscomp/edit/row_positions.h"
#include "mscomp/model/shape_model.h"

namespace mscomp {

/// Positions as a function of codes: what the model decodes to, made into vertices. Borrows the
/// model. Safe to use from several threads.
class CodePositions {
  public:
    CodePositions(const ShapeModel& model, const TriangleMesh& reference, EdgeWeights weights,
                  VertexSolver solver);

    int code_count() const { return code_count_; }
    int vertex_count() const { return model_.vertex_count(); }

    /// Rows of the model, unscaled, of the first `levels` levels; 0 means all.
    std::vector<float> rows(std::span<const float> codes, int levels = 0) const;
    /// (V) of rows, as RowPositions.
    std::vector<Point> positions(std::span<const float> rows,
                                 std::span<const Point> like = {}) const;
    /// (n,V,3) in n of the codes `which` at `codes`, whose rows are given, as RowPositions.
    std::vector<double> derivatives(std::span<const float> codes, std::span<const float> rows,
                                    std::span<const int> which) const;

  private:
    const ShapeModel& model_;
    int code_count_;
    RowPositions positions_;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/edit/row_positions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

/// Takes their mean off the displacements (V,3).
void keep_centroid(std::span<double> displacements) {
    const std::size_t count = displacements.size() / 3;
    Point mean{};
    for (std::size_t i = 0; i < 3 * count; ++i) mean[i % 3] += displacements[i];
    for (double& x : mean) x /= static_cast<double>(count);
    for (std::size_t i = 0; i < 3 * count; ++i) displacements[i] -= mean[i % 3];
}

}  // namespace

VertexSolver parse_vertex_solver(const std::string& name) {
    if (name == "poisson") return VertexSolver::poisson;
    if (name == "lossless") return VertexSolver::lossless;
    throw UsageError(fmt::format("vertex solver '{}': wanted poisson or lossless", name));
}

std::string to_string(VertexSolver solver) {
    return solver == VertexSolver::poisson ? "poisson" : "lossless";
}

RowPositions::RowPositions(ShapeRows rows, const TriangleMesh& reference, EdgeWeights weights,
                           VertexSolver solver)
    : rows_(rows), vertex_count_(reference.vertices.size()) {
    if (rows == ShapeRows::positions) return;
    if (solver == VertexSolver::poisson) {
        poisson_.emplace(reference, weights);
    } else {
        lossless_.emplace(reference, weights);
    }
}

std::vector<Point> RowPositions::positions(std::span<const float> rows,
                                           std::span<const Point> like) const {
    if (poisson_) return poisson_->solve(rows, like, Pieces::joined);
    if (lossless_) return lossless_->solve(rows, like, Pieces::joined).vertices;
    if (rows.size() != 3 * vertex_count_) {
        throw MeshError(
            fmt::format("{} coordinates, wanted those of {} vertices", rows.size(), vertex_count_));
    }
    if (!std::ranges::all_of(rows, [](float x) { return std::isfinite(x); })) {
        throw NumericalError("positions that are not finite");
    }
    return points_of(rows);
}

std::vector<double> RowPositions::derivatives(std::span<const float> rows,
                                              std::span<const CodeColumn> directions) const {
    if (rows_ == ShapeRows::positions) return position_columns(directions);
    std::vector<FeatureDirection> borrowed;
    borrowed.reserve(directions.size());
    for (const CodeColumn& d : directions) borrowed.push_back({d.vertices, d.values});
    std::vector<double> result(directions.size() * 3 * vertex_count_);
    if (poisson_) {
        poisson_->derivatives(rows, borrowed, result);
    } else {
        lossless_->derivatives(rows, borrowed, result);
    }
    return result;
}

std::vector<double> RowPositions::position_columns(std::span<const CodeColumn> directions) const {
    const std::size_t width = 3 * vertex_count_;
    std::vector<double> result(directions.size() * width, 0.0);
    for (std::size_t k = 0; k < directions.size(); ++k) {
        const std::span<double> column = std::span(result).subspan(k * width, width);
        for (std::size_t i = 0; i < directions[k].values.size(); ++i) {
            column[3 * at(directions[k].vertices[i / 3]) + i % 3] =
                static_cast<double>(directions[k].values[i]);
        }
        keep_centroid(column);
    }
    return result;
}

}  // namespace mscomp

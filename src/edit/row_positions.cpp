// SPDX-License-Identifier: MIT
#include "mscomp/edit/row_positions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

/// Takes its centroid off every component of the displacements (V,3).
void keep_centroids(std::span<double> displacements, const std::vector<int>& component) {
    const auto count = at(*std::ranges::max_element(component) + 1);
    std::vector<Point> sums(count, Point{});
    std::vector<int> sizes(count, 0);
    for (std::size_t v = 0; v < component.size(); ++v) {
        ++sizes[at(component[v])];
        for (std::size_t x = 0; x < 3; ++x) sums[at(component[v])][x] += displacements[3 * v + x];
    }
    for (std::size_t v = 0; v < component.size(); ++v) {
        const auto c = at(component[v]);
        for (std::size_t x = 0; x < 3; ++x) displacements[3 * v + x] -= sums[c][x] / sizes[c];
    }
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
    : rows_(rows),
      component_(
          connected_components(one_rings_of_faces(reference.vertex_count(), reference.faces))) {
    if (rows == ShapeRows::positions) return;
    if (solver == VertexSolver::poisson) {
        poisson_.emplace(reference, weights);
    } else {
        lossless_.emplace(reference, weights);
    }
}

std::vector<Point> RowPositions::positions(std::span<const float> rows,
                                           std::span<const Point> like) const {
    if (poisson_) return poisson_->solve(rows, like);
    if (lossless_) return lossless_->solve(rows, like).vertices;
    if (rows.size() != 3 * component_.size()) {
        throw MeshError(fmt::format("{} coordinates, wanted those of {} vertices", rows.size(),
                                    component_.size()));
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
    std::vector<double> result(directions.size() * 3 * component_.size());
    if (poisson_) {
        poisson_->derivatives(rows, borrowed, result);
    } else {
        lossless_->derivatives(rows, borrowed, result);
    }
    return result;
}

std::vector<double> RowPositions::position_columns(std::span<const CodeColumn> directions) const {
    const std::size_t width = 3 * component_.size();
    std::vector<double> result(directions.size() * width, 0.0);
    for (std::size_t k = 0; k < directions.size(); ++k) {
        const std::span<double> column = std::span(result).subspan(k * width, width);
        for (std::size_t i = 0; i < directions[k].values.size(); ++i) {
            column[3 * at(directions[k].vertices[i / 3]) + i % 3] =
                static_cast<double>(directions[k].values[i]);
        }
        keep_centroids(column, component_);
    }
    return result;
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/edit/code_positions.h"

#include <utility>

#include "mscomp/base/index.h"

namespace mscomp {

CodePositions::CodePositions(const ShapeModel& model, const TriangleMesh& reference,
                             EdgeWeights weights, VertexSolver solver)
    : model_(model),
      code_count_(model.code_count()),
      positions_(model.rows(), reference, weights, solver) {}

std::vector<float> CodePositions::rows(std::span<const float> codes, int levels) const {
    return model_.decode(codes, levels);
}

std::vector<Point> CodePositions::positions(std::span<const float> rows,
                                            std::span<const Point> like) const {
    return positions_.positions(rows, like);
}

std::vector<double> CodePositions::derivatives(std::span<const float> codes,
                                               std::span<const float> rows,
                                               std::span<const int> which) const {
    std::vector<CodeColumn> columns = model_.derivatives(codes);
    std::vector<CodeColumn> wanted;
    wanted.reserve(which.size());
    for (const int code : which) wanted.push_back(std::move(columns[at(code)]));
    return positions_.derivatives(rows, wanted);
}

}  // namespace mscomp

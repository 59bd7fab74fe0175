// SPDX-License-Identifier: MIT
// What depends on how fine a mesh is.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

namespace mscomp::nn {

/// Numbers that are given for "a mesh" hold as they are up to so many vertices.
inline constexpr double kOrdinaryVertices = 10000;

/// Codes are sums over vertices of features times weights of unit length: on finer meshes they grow
/// by this.
inline double code_growth(int vertices) {
    return std::sqrt(std::max(1.0, vertices / kOrdinaryVertices));
}

/// The range penalty of codes: theta, and the weight of the term in the loss.
struct CodeLimit {
    double limit, weight;
};

/// As given where there is a `limit`, the same number on every mesh ([A], [B]). Otherwise 5 up to
/// an ordinary mesh and the same to the model on finer ones: the limit grows as codes do, and so
/// does the weight, since the error it stands beside grows with the square.
inline CodeLimit code_limit(const std::optional<double>& limit, double weight, int vertices) {
    constexpr double kOrdinaryLimit = 5;
    if (limit) return {*limit, weight};
    return {kOrdinaryLimit * code_growth(vertices), weight * code_growth(vertices)};
}

}  // namespace mscomp::nn

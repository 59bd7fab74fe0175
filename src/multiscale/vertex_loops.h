// SPDX-License-Identifier: MIT
// Loops over vertices and what they have as matrices.
#pragma once

#include <Eigen/Core>
#include <numeric>
#include <vector>

#include "mscomp/base/parallel.h"
#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"

namespace mscomp {

/// Calls body(v) for all vertices, in parallel.
template <class Body>
void for_vertices(int vertices, const Body& body) {
    const Chunks chunks{vertices, 64};
    parallel_for(chunks.count(), [&](std::int64_t i) {
        for (std::int64_t v = chunks.begin(i); v < chunks.end(i); ++v) body(static_cast<int>(v));
    });
}

/// The sum of body(v), the same bits for any number of threads.
template <class Body>
double sum_over_vertices(int vertices, const Body& body) {
    const Chunks chunks{vertices, 64};
    std::vector<double> sums(at(chunks.count()), 0.0);
    parallel_for(chunks.count(), [&](std::int64_t i) {
        for (std::int64_t v = chunks.begin(i); v < chunks.end(i); ++v) {
            sums[at(i)] += body(static_cast<int>(v));
        }
    });
    return std::accumulate(sums.begin(), sums.end(), 0.0);
}

using ShapesOfVertex = Eigen::Matrix<double, 9, Eigen::Dynamic, Eigen::RowMajor>;
using ValuesAtVertex = Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor>;

/// What the shapes have at a vertex, (9,shapes).
inline ShapesOfVertex shapes_at(const MetricRows& rows, int v) {
    using Floats = Eigen::Matrix<float, 9, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const Floats>(rows.vertex(v).data(), 9, rows.shape_count()).cast<double>();
}

/// Values of the components that act at a vertex, (n,9).
inline ValuesAtVertex values_at(const BallComponents& components, int v) {
    using Floats = Eigen::Matrix<float, Eigen::Dynamic, 9, Eigen::RowMajor>;
    const std::span<const float> values = components.values(v);
    return Eigen::Map<const Floats>(values.data(), static_cast<Eigen::Index>(values.size() / 9), 9)
        .cast<double>();
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
// Loops over vertices and what they have as matrices.
#pragma once

#include <Eigen/Core>
#include <cassert>
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

template <int Width>
using ShapesAt = Eigen::Matrix<double, Width, Eigen::Dynamic, Eigen::RowMajor>;
template <int Width>
using ValuesAt = Eigen::Matrix<double, Eigen::Dynamic, Width, Eigen::RowMajor>;
using ShapesOfVertex = ShapesAt<kFeatureDim>;
using ValuesAtVertex = ValuesAt<kFeatureDim>;

/// What the shapes have at a vertex, (Width,shapes). Rows are of that width, as all below.
template <int Width = kFeatureDim>
ShapesAt<Width> shapes_at(const MetricRows& rows, int v) {
    assert(rows.width() == Width);
    using Floats = Eigen::Matrix<float, Width, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const Floats>(rows.vertex(v).data(), Width, rows.shape_count())
        .template cast<double>();
}

/// Values of the components that act at a vertex, (n,Width).
template <int Width = kFeatureDim>
ValuesAt<Width> values_at(const BallComponents& components, int v) {
    assert(components.width() == Width);
    using Floats = Eigen::Matrix<float, Eigen::Dynamic, Width, Eigen::RowMajor>;
    const std::span<const float> values = components.values(v);
    const auto count = static_cast<Eigen::Index>(values.size()) / Width;
    return Eigen::Map<const Floats>(values.data(), count, Width).template cast<double>();
}

/// body<width>(): so that loops over the numbers of a vertex know how many there are.
template <class Body>
auto with_width(int width, const Body& body) {
    if (width == kFeatureDim) return body.template operator()<kFeatureDim>();
    assert(width == 3);
    return body.template operator()<3>();
}

}  // namespace mscomp

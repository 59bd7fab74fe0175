// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/aligned.h"
#include "mscomp/base/metric_scale.h"
#include "mscomp/base/shape_features.h"
#include "nn/vertex_order.h"

namespace mscomp::nn {

/// What the network sees of features that lie elsewhere, borrowed: scaled in double, rounded to
/// float once.
struct ScaledFeatures {
    const ShapeFeatures& shapes;
    MetricScale scale{};
};

/// A batch as the network reads it.
struct LaneBatch {
    std::vector<int> shapes;    // of the lanes
    AlignedVector<float> rows;  // (V,9,lanes) in inner vertex order, 0 in lanes without a shape
};

enum class GatherThreads { all, one };

/// Shapes `which`, at most as many as there are lanes, as `rows` (V,9,lanes) in the vertex order
/// `order`. They are read 16 at a time and forgotten then.
template <class T>
void gather_lanes(const ScaledFeatures& features, std::span<const int> which,
                  const VertexOrder& order, std::span<T> rows, GatherThreads threads);

}  // namespace mscomp::nn

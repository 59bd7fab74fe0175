// SPDX-License-Identifier: MIT
#include "position_derivatives.h"

#include <cassert>
#include <vector>

#include "acap/rotation.h"
#include "feature_derivative.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "position_group.h"

namespace mscomp {
namespace {

Feature feature_at(std::span<const float> features, std::size_t place) {
    const float* feature = features.data() + place * kFeatureDim;
    return Eigen::Map<const Eigen::Matrix<float, 9, 1>>(feature).cast<double>();
}

std::vector<FeatureDerivative> derivatives_at(std::span<const float> features,
                                              std::size_t vertex_count) {
    gradients_of_features(features, vertex_count);  // throws
    std::vector<FeatureDerivative> result;
    result.reserve(vertex_count);
    for (std::size_t i = 0; i < vertex_count; ++i) result.emplace_back(feature_at(features, i));
    return result;
}

void add_direction(const FeatureDirection& direction, std::size_t place,
                   const std::vector<FeatureDerivative>& derivatives, PositionGroup& group) {
    assert(direction.values.size() == direction.vertices.size() * kFeatureDim);
    for (std::size_t n = 0; n < direction.vertices.size(); ++n) {
        const auto v = at(direction.vertices[n]);
        group.add(v, place, derivatives[v].change(feature_at(direction.values, n)));
    }
}

}  // namespace

void position_derivatives(const LinearPositions& positions, std::span<const float> features,
                          std::span<const FeatureDirection> directions, std::span<double> result) {
    const std::vector<FeatureDerivative> derivatives =
        derivatives_at(features, positions.vertex_count());
    const std::size_t size = 3 * derivatives.size();
    assert(result.size() == directions.size() * size);
    const Chunks groups{static_cast<std::int64_t>(directions.size()), PositionGroup::kSize};
    parallel_for(groups.count(), [&](std::int64_t g) {
        const auto first = at(groups.begin(g));
        const auto last = at(groups.end(g));
        PositionGroup group(positions);
        group.clear();
        for (std::size_t k = first; k < last; ++k) {
            add_direction(directions[k], k - first, derivatives, group);
        }
        group.solve();
        group.get(result.subspan(first * size, (last - first) * size));
    });
}

}  // namespace mscomp

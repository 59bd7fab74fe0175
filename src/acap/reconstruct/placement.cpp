// SPDX-License-Identifier: MIT
#include "placement.h"

#include <fmt/format.h>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {

Placement::Placement(const OneRings& rings, std::vector<Point> reference)
    : component_(connected_components(rings)) {
    for (std::size_t i = 0; i < component_.size(); ++i) {
        if (component_[i] != component_count_) continue;
        ++component_count_;
        first_vertices_.push_back(static_cast<int>(i));
    }
    reference_centroids_ = centroids(reference);
}

std::vector<Point> Placement::centroids(std::span<const Point> positions) const {
    const auto count = at(component_count_);
    std::vector<Point> sums(count, Point{});
    std::vector<int> sizes(count, 0);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const auto c = at(component_[i]);
        ++sizes[c];
        for (std::size_t axis = 0; axis < 3; ++axis) sums[c][axis] += positions[i][axis];
    }
    for (std::size_t c = 0; c < count; ++c) {
        for (double& x : sums[c]) x /= sizes[c];
    }
    return sums;
}

void Placement::apply(std::span<const Point> like, std::vector<Point>& positions,
                      const std::vector<char>& left_alone) const {
    if (!like.empty() && like.size() != positions.size()) {
        throw MeshError(fmt::format("placement like a shape of {} vertices, wanted {}", like.size(),
                                    positions.size()));
    }
    const std::vector<Point> wanted = like.empty() ? reference_centroids_ : centroids(like);
    const std::vector<Point> found = centroids(positions);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const auto c = at(component_[i]);
        if (!left_alone.empty() && left_alone[c] != 0) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            positions[i][axis] += wanted[c][axis] - found[c][axis];
        }
    }
}

}  // namespace mscomp

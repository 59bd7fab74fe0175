// SPDX-License-Identifier: MIT
#include "mscomp/acap/feature_layer.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "feature_lanes.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/points.h"
#include "poisson_system.h"
#include "position_group.h"
#include "tangential_system.h"

namespace mscomp {
namespace {

/// Groups that are not in use, kept for those who need one next.
class IdleGroups {
  public:
    explicit IdleGroups(const LinearPositions& positions) : positions_(positions) {}

    std::unique_ptr<PositionGroup> take() {
        {
            const std::lock_guard lock(mutex_);
            if (!idle_.empty()) {
                auto group = std::move(idle_.back());
                idle_.pop_back();
                return group;
            }
        }
        return std::make_unique<PositionGroup>(positions_);
    }
    void give_back(std::unique_ptr<PositionGroup> group) {
        const std::lock_guard lock(mutex_);
        idle_.push_back(std::move(group));
    }

  private:
    LinearPositions positions_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<PositionGroup>> idle_;
};

/// (V,3) relative to their mean.
std::vector<double> centered(const std::vector<Point>& points) {
    std::vector<double> result;
    const Point mean = mean_point(points);
    for (const Point& point : points) {
        const Point entry = minus(point, mean);
        result.insert(result.end(), entry.begin(), entry.end());
    }
    return result;
}

/// One vertex of up to PositionGroup::kSize shapes of (V,9) each.
void read_lanes(std::span<const double> features, std::size_t vertex, std::size_t size,
                NineLanes& lanes) {
    for (std::size_t k = 0; k * size < features.size(); ++k) {
        const double* feature = features.data() + k * size + vertex * kFeatureDim;
        for (std::size_t c = 0; c < kFeatureDim; ++c) lanes[c][k] = feature[c];
    }
}
void write_lanes(const NineLanes& lanes, std::size_t vertex, std::size_t size,
                 std::span<double> features) {
    for (std::size_t k = 0; k * size < features.size(); ++k) {
        double* feature = features.data() + k * size + vertex * kFeatureDim;
        for (std::size_t c = 0; c < kFeatureDim; ++c) feature[c] = lanes[c][k];
    }
}

/// Of the first of the shapes for which something is not finite; they are numbered from `first`.
void check_finite(const NineLanes& lanes, std::size_t first, std::size_t vertex) {
    Lanes<8> zero{};  // x 0 is NaN of what is not finite
    for (const Lanes<8>& channel : lanes) {
        for (std::size_t k = 0; k < 8; ++k) zero[k] += 0 * channel[k];
    }
    for (std::size_t k = 0; k < 8; ++k) {
        if (zero[k] == 0) continue;
        throw NumericalError(
            fmt::format("feature of shape {}, vertex {} is not finite", first + k, vertex));
    }
}

void check_size(std::size_t count, const char* what, std::size_t shapes, std::size_t vertices,
                int channels) {
    if (count == shapes * vertices * at(channels)) return;
    throw MeshError(fmt::format("{} values of {}, wanted {} x {} x {}", count, what, shapes,
                                vertices, channels));
}

}  // namespace

struct FeatureLayer::State {
    State(const TriangleMesh& mesh, EdgeWeights weights, LayerEquations equations)
        : reference(centered(mesh.vertices)) {
        if (equations == LayerEquations::poisson) {
            groups.emplace(poisson.emplace(mesh, weights).positions());
        } else {
            groups.emplace(tangential.emplace(mesh, weights).positions());
        }
    }

    std::size_t vertex_count() const { return reference.size() / 3; }
    std::size_t shape_count(std::span<const double> features) const {
        const std::size_t size = vertex_count() * kFeatureDim;
        const std::size_t count = size > 0 ? features.size() / size : 0;
        check_size(features.size(), "features", count, vertex_count(), kFeatureDim);
        return count;
    }

    template <class Body>
    void for_each_group(std::size_t shape_count, Body&& body);

    std::vector<double> reference;  // (V,3), its mean 0
    std::optional<PoissonSystem> poisson;
    std::optional<TangentialSystem> tangential;
    std::optional<IdleGroups> groups;
};

/// Calls body(group, first, count), in parallel, for up to PositionGroup::kSize shapes at a time.
template <class Body>
void FeatureLayer::State::for_each_group(std::size_t shape_count, Body&& body) {
    const Chunks chunks{static_cast<std::int64_t>(shape_count), PositionGroup::kSize};
    parallel_for(chunks.count(), [&](std::int64_t c) {
        std::unique_ptr<PositionGroup> group = groups->take();
        body(*group, at(chunks.begin(c)), at(chunks.end(c) - chunks.begin(c)));
        groups->give_back(std::move(group));
    });
}

FeatureLayer::FeatureLayer(const TriangleMesh& reference, EdgeWeights weights,
                           LayerEquations equations)
    : state_(std::make_unique<State>(reference, weights, equations)) {}
FeatureLayer::FeatureLayer(FeatureLayer&&) noexcept = default;
FeatureLayer& FeatureLayer::operator=(FeatureLayer&&) noexcept = default;
FeatureLayer::~FeatureLayer() = default;

int FeatureLayer::vertex_count() const { return static_cast<int>(state_->vertex_count()); }

void FeatureLayer::positions(std::span<const double> features, std::span<double> positions) const {
    const std::size_t vertex_count = state_->vertex_count(), size = 3 * vertex_count;
    const std::size_t feature_size = kFeatureDim * vertex_count;
    const std::size_t shape_count = state_->shape_count(features);
    check_size(positions.size(), "positions", shape_count, vertex_count, 3);
    const auto solve = [&](PositionGroup& group, std::size_t first, std::size_t count) {
        const auto own = features.subspan(first * feature_size, count * feature_size);
        NineLanes lanes{}, changes;
        group.clear();
        for (std::size_t v = 0; v < vertex_count; ++v) {
            read_lanes(own, v, feature_size, lanes);
            gradient_changes(lanes, turns_of_features(lanes), changes);
            check_finite(changes, first, v);
            group.add(v, changes);
        }
        group.solve();
        const std::span<double> shapes = positions.subspan(first * size, count * size);
        group.get(shapes);
        for (std::size_t k = 0; k < count; ++k) {
            for (std::size_t i = 0; i < size; ++i) shapes[k * size + i] += state_->reference[i];
        }
    };
    state_->for_each_group(shape_count, solve);
}

void FeatureLayer::adjoint(std::span<const double> features, std::span<const double> by_position,
                           std::span<double> by_feature) const {
    const std::size_t vertex_count = state_->vertex_count(), size = 3 * vertex_count;
    const std::size_t feature_size = kFeatureDim * vertex_count;
    const std::size_t shape_count = state_->shape_count(features);
    check_size(by_position.size(), "derivatives by positions", shape_count, vertex_count, 3);
    check_size(by_feature.size(), "derivatives by features", shape_count, vertex_count,
               kFeatureDim);
    const auto solve = [&](PositionGroup& group, std::size_t first, std::size_t count) {
        const auto own = features.subspan(first * feature_size, count * feature_size);
        const auto own_result = by_feature.subspan(first * feature_size, count * feature_size);
        NineLanes lanes{}, by_gradient, result;
        group.set(by_position.subspan(first * size, count * size));
        group.solve_adjoint();
        for (std::size_t v = 0; v < vertex_count; ++v) {
            read_lanes(own, v, feature_size, lanes);
            check_finite(lanes, first, v);
            group.by_gradient(v, by_gradient);
            feature_adjoint(lanes, turns_of_features(lanes), by_gradient, result);
            write_lanes(result, v, feature_size, own_result);
        }
    };
    state_->for_each_group(shape_count, solve);
}

}  // namespace mscomp

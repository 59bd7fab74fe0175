// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/points.h"
#include "mscomp/render/overview.h"

namespace mscomp {
namespace {

double diagonal_of(std::span<const Point> vertices) {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    double square = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        double low = kFar, high = -kFar;
        for (const Point& p : vertices) {
            low = std::min(low, p[k]);
            high = std::max(high, p[k]);
        }
        square += (high - low) * (high - low);
    }
    return std::sqrt(square);
}

void require_sound(const TriangleMesh& reference, std::span<const ShownMotion> motions) {
    fit_view(reference.vertices);  // throws where there is nothing to look at
    for (const Face& face : reference.faces) {
        for (const int v : face) {
            if (v < 0 || v >= reference.vertex_count()) {
                throw MeshError(fmt::format("overview: a face refers to vertex {} of {}", v,
                                            reference.vertex_count()));
            }
        }
    }
    for (const ShownMotion& motion : motions) {
        if (!motion.moved.empty()) fit_view(motion.moved);
    }
}

std::vector<Point> both(const TriangleMesh& reference, const std::vector<Point>& moved) {
    std::vector<Point> all = reference.vertices;
    all.insert(all.end(), moved.begin(), moved.end());
    return all;
}

void aim(const TriangleMesh& reference, const std::vector<Point>& moved, const Stance& stance,
         OverviewTile& tile) {
    View view;
    view.axes = axes_from(stance, tile.viewpoint);
    tile.whole = framed(view, both(reference, moved));
    tile.zoom = zoomed(view, reference.vertices, moved, tile.motion);
    tile.is_zoomed = tile.zoom.half_extent < tile.whole.half_extent;
}

}  // namespace

OverviewPlan plan_overview(const TriangleMesh& reference, std::span<const ShownMotion> motions,
                           const OverviewOptions& options) {
    require_sound(reference, motions);
    std::vector<int> parents;
    for (const ShownMotion& motion : motions) parents.push_back(motion.parent);

    OverviewPlan plan;
    plan.layout = family_layout(parents, options.columns);
    plan.diagonal = diagonal_of(reference.vertices);
    plan.is_up_guessed = !options.up;
    plan.stance =
        options.up ? stance_of(reference.vertices, *options.up) : stance_of(reference.vertices);
    const bool is_open = face_open_front(reference, plan.stance);

    plan.tiles.resize(motions.size());
    std::vector<std::vector<double>> shown(motions.size(),
                                           std::vector<double>(tried_viewpoints().size(), 0.0));
    parallel_for(static_cast<std::int64_t>(motions.size()), [&](std::int64_t i) {
        const std::vector<Point>& moved = motions[at(i)].moved;
        if (moved.empty()) return;
        OverviewTile& tile = plan.tiles[at(i)];
        tile.motion = motion_of(reference.vertices, moved);
        // Without a direction that was asked for, and to know which side is the front.
        if (options.view && is_open) return;
        shown[at(i)] = motion_from_viewpoints(reference, moved, tile.motion, plan.stance);
    });
    if (!is_open) face_motion(plan.stance, shown);

    double largest = 0;
    for (const OverviewTile& tile : plan.tiles) largest = std::max(largest, tile.motion.largest);
    plan.largest = plan.diagonal > 0 ? 100 * largest / plan.diagonal : 0;
    for (std::size_t i = 0; i < motions.size(); ++i) {
        OverviewTile& tile = plan.tiles[i];
        if (motions[i].moved.empty()) continue;
        tile.near_empty = !(tile.motion.largest >= kNearEmptyShare * largest) || !(largest > 0);
        tile.viewpoint = options.view ? *options.view : most_telling(shown[i]);
        aim(reference, motions[i].moved, plan.stance, tile);
    }
    return plan;
}

double place_on_scale(double percent, double largest) {
    return largest > 0 ? std::sqrt(std::clamp(percent / largest, 0.0, 1.0)) : 0;
}

std::vector<double> scale_ticks(double largest) {
    return {0, largest / 16, largest / 4, largest * 9 / 16, largest};
}

}  // namespace mscomp

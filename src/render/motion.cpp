// SPDX-License-Identifier: MIT
#include "mscomp/render/motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/points.h"

namespace mscomp {
namespace {

constexpr double kAround = 1.125;      // of the moving vertices
constexpr double kClosest = 0.125;     // of the whole
constexpr double kNearlyWhole = 0.75;  // of the whole: no use in coming nearer
constexpr std::size_t kAzimuths = 8;

/// Where `viewpoint` is in tried_viewpoints(), turned by `quarters`.
std::size_t turned_place(std::size_t place, std::size_t quarters) {
    const auto within = [quarters](std::size_t begin, std::size_t count, std::size_t i) {
        return begin + (i - begin + quarters * count / 4) % count;
    };
    if (place < kAzimuths) return within(0, kAzimuths, place);
    return place < kAzimuths + 4 ? within(kAzimuths, 4, place) : within(kAzimuths + 4, 4, place);
}

}  // namespace

Motion motion_of(std::span<const Point> reference, std::span<const Point> moved) {
    if (reference.size() != moved.size()) {
        throw UsageError(fmt::format("motion: {} vertices, the reference has {}", moved.size(),
                                     reference.size()));
    }
    Motion motion;
    motion.amount.reserve(reference.size());
    for (std::size_t v = 0; v < reference.size(); ++v) {
        motion.amount.push_back(std::sqrt(square_distance(reference[v], moved[v])));
        motion.largest = std::max(motion.largest, motion.amount.back());
    }
    if (!(motion.largest > 0)) return motion;
    for (std::size_t v = 0; v < reference.size(); ++v) {
        if (motion.amount[v] >= kMovingShare * motion.largest) {
            motion.moving.push_back(static_cast<int>(v));
        }
    }
    return motion;
}

View zoomed(const View& view, std::span<const Point> reference, std::span<const Point> moved,
            const Motion& motion, double picture_aspect) {
    std::vector<Point> all(reference.begin(), reference.end());
    all.insert(all.end(), moved.begin(), moved.end());
    const View whole = framed(view, all, picture_aspect);
    if (motion.moving.empty()) return whole;
    std::vector<Point> moving;
    for (const int v : motion.moving) {
        moving.push_back(reference[at(v)]);
        moving.push_back(moved[at(v)]);
    }
    View near = framed(view, moving, picture_aspect);
    near.half_extent = std::max(kAround * near.half_extent, kClosest * whole.half_extent);
    return near.half_extent >= kNearlyWhole * whole.half_extent ? whole : near;
}

const std::vector<Viewpoint>& tried_viewpoints() {
    static const std::vector<Viewpoint> tried = [] {
        std::vector<Viewpoint> list;
        for (std::size_t k = 0; k < kAzimuths; ++k) {
            list.push_back({45.0 * static_cast<double>(k), 10});
        }
        for (const double elevation : {60.0, -45.0}) {
            for (const double azimuth : {0.0, 90.0, 180.0, 270.0}) {
                list.push_back({azimuth, elevation});
            }
        }
        return list;
    }();
    return tried;
}

std::vector<double> motion_from_viewpoints(const TriangleMesh& reference,
                                           std::span<const Point> moved, const Motion& motion,
                                           const Stance& stance) {
    std::vector<double> shown;
    for (const Viewpoint& viewpoint : tried_viewpoints()) {
        shown.push_back(visible_motion(reference, moved, motion, axes_from(stance, viewpoint)));
    }
    return shown;
}

Viewpoint most_telling(const std::vector<double>& shown) {
    std::size_t best = 0;
    double most = shown.front();
    for (std::size_t i = 1; i < shown.size(); ++i) {
        const double weighed = shown[i] / (i < kAzimuths ? kWorthTurning : kWorthRising);
        if (!(weighed > most)) continue;
        most = weighed;
        best = i;
    }
    return tried_viewpoints()[best];
}

void face_motion(Stance& stance, std::vector<std::vector<double>>& shown) {
    std::array<double, 4> total{0, 0, 0, 0};
    for (const std::vector<double>& list : shown) {
        double sum = 0;
        for (std::size_t quarter = 0; quarter < 4; ++quarter) sum += list[2 * quarter];
        if (!(sum > 0)) continue;
        for (std::size_t quarter = 0; quarter < 4; ++quarter) {
            total[quarter] += list[2 * quarter] / sum;
        }
    }
    const auto best = std::ranges::max_element(total);
    if (!(*best > kWorthTurning * total[0])) return;
    const auto quarters = static_cast<std::size_t>(best - total.begin());
    for (std::size_t turn = 0; turn < quarters; ++turn) {
        stance.front = cross(stance.up, stance.front);
    }
    for (std::vector<double>& list : shown) {
        std::vector<double> turned(list.size());
        for (std::size_t i = 0; i < list.size(); ++i) turned[i] = list[turned_place(i, quarters)];
        list = turned;
    }
}

}  // namespace mscomp

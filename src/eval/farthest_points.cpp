// SPDX-License-Identifier: MIT
#include "mscomp/eval/farthest_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/points.h"

namespace mscomp {

std::vector<int> farthest_point_samples(const std::vector<Point>& points, int count) {
    if (count < 0 || at(count) > points.size()) {
        throw UsageError(fmt::format("farthest points: {} of {} vertices, wanted 0 to {}", count,
                                     points.size(), points.size()));
    }
    std::vector<double> distance;  // to the centroid, then to the nearest sample; -1 for samples
    const Point center = centroid(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        distance.push_back(square_distance(points[i], center));
        if (!std::isfinite(distance.back())) {
            throw MeshError(
                fmt::format("farthest points: vertex {} is ({}, {}, {}), wanted finite numbers "
                            "whose squares are finite",
                            i, points[i][0], points[i][1], points[i][2]));
        }
    }
    std::vector<int> samples;
    while (static_cast<int>(samples.size()) < count) {
        const auto next = at(std::ranges::max_element(distance) - distance.begin());
        const bool is_first = samples.empty();
        samples.push_back(static_cast<int>(next));
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double square = square_distance(points[i], points[next]);
            distance[i] = is_first ? square : std::min(distance[i], square);
        }
        distance[next] = -1;
    }
    return samples;
}

}  // namespace mscomp

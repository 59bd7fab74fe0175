// SPDX-License-Identifier: MIT
#include "multiscale/ball_start.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

#include "learning/deflation.h"

namespace mscomp {
namespace {

/// The vertices within reach of a centre, rising: within the range, and no more than the largest
/// share.
std::vector<int> ball_vertices(std::span<const double> distances, const BallLevel& level) {
    const auto most = std::max<std::size_t>(
        1, static_cast<std::size_t>(level.max_support * static_cast<double>(distances.size())));
    double reach = level.sparsity_range;
    bool is_limited = false;
    if (most < distances.size()) {
        std::vector<double> sorted(distances.begin(), distances.end());
        const auto outside = sorted.begin() + static_cast<std::ptrdiff_t>(most);
        std::nth_element(sorted.begin(), outside, sorted.end());
        is_limited = *outside <= reach;
        reach = std::min(reach, *outside);
    }
    std::vector<int> vertices;
    for (std::size_t v = 0; v < distances.size(); ++v) {
        // Nearer than the one after the last that fits, or within the range.
        if (is_limited ? distances[v] < reach : distances[v] <= reach) {
            vertices.push_back(static_cast<int>(v));
        }
    }
    return vertices;
}

/// Components as they are found.
struct Found {
    std::vector<Ball> balls;
    std::vector<std::vector<float>> values;  // (n,9) each

    void add(const DeflationResidual& residual, const DeflationDirection& direction, Ball ball) {
        std::vector<float> own(9 * ball.vertices.size(), 0.0F);
        for (std::size_t n = 0; n < direction.places.size(); ++n) {
            const int v = residual.vertices()[at(direction.places[n])];
            const auto place = std::ranges::lower_bound(ball.vertices, v) - ball.vertices.begin();
            for (std::size_t c = 0; c < 9; ++c) {
                own[9 * at(place) + c] = static_cast<float>(direction.values[9 * n + c]);
            }
        }
        balls.push_back(std::move(ball));
        values.push_back(std::move(own));
    }
};

void find_global(int count, DeflationResidual& residual, int vertex_count, Found& found) {
    std::vector<int> everything(at(vertex_count)), places(residual.vertices().size());
    std::iota(everything.begin(), everything.end(), 0);
    std::iota(places.begin(), places.end(), 0);
    for (int k = 0; k < count; ++k) {
        const DeflationDirection direction =
            residual.main_direction(residual.strongest_vertex(), places);
        residual.subtract(direction);
        found.add(residual, direction, {residual.longest_vertex(direction), everything});
    }
}

/// How many centres lie around each vertex.
class Crowds {
  public:
    Crowds(const CenterSpread& spread, int vertex_count)
        : spread_(spread), counts_(at(vertex_count), 0) {}
    void add(std::span<const double> distances) {
        for (std::size_t v = 0; v < counts_.size(); ++v) {
            counts_[v] += distances[v] <= spread_.radius ? 1 : 0;
        }
    }
    bool is_crowded(int v) const { return counts_[at(v)] >= spread_.most; }

  private:
    CenterSpread spread_;
    std::vector<int> counts_;
};

/// Indices of those of `vertices` that are in `ball`; both rise.
std::vector<int> places_within(std::span<const int> vertices, std::span<const int> ball) {
    std::vector<int> places;
    std::size_t next = 0;
    for (std::size_t n = 0; n < vertices.size() && next < ball.size(); ++n) {
        while (next < ball.size() && ball[next] < vertices[n]) ++next;
        if (next < ball.size() && ball[next] == vertices[n]) places.push_back(static_cast<int>(n));
    }
    return places;
}

}  // namespace

BallComponents start_balls(const MetricRows& rows, const MultiscaleSettings& settings,
                           DistanceRows& distances) {
    const int vertices = rows.vertex_count(), shapes = rows.shape_count();
    DeflationResidual residual(vertices, shapes);
    residual.fill(rows.all().data(), shapes, 0, shapes, [](double x) { return x; });
    residual.drop_silent_vertices();
    Found found;
    find_global(settings.global_components, residual, vertices, found);
    Crowds crowds(settings.spread, vertices);
    const std::vector<int> candidates = spread_vertices(distances, kCandidates);
    for (const BallLevel& level : settings.levels) {
        const auto ball_around = [&](int center) {
            return ball_vertices(distances.row(center), level);
        };
        Deflation deflation(
            residual, distances,
            [&](int center, std::span<const int> of) {
                return places_within(of, ball_around(center));
            },
            candidates);
        for (int k = 0; k < level.components; ++k) {
            const FoundComponent next = deflation.next([&](int v) { return crowds.is_crowded(v); });
            crowds.add(distances.row(next.center));
            found.add(residual, next.direction, {next.center, ball_around(next.center)});
        }
    }
    BallComponents components(vertices, std::move(found.balls));
    for (int k = 0; k < components.count(); ++k) components.set_component(k, found.values[at(k)]);
    return components;
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "multiscale/ball_start.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "learning/deflation.h"
#include "learning/reach.h"

namespace mscomp {
namespace {

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

void find_global(int count, double first_energy, DeflationResidual& residual,
                 const std::vector<int>& everything, Found& found) {
    std::vector<int> places(residual.vertices().size());
    std::iota(places.begin(), places.end(), 0);
    for (int k = 0; k < count; ++k) {
        const int strongest = residual.strongest_vertex();
        DeflationDirection direction = residual.main_direction(strongest, places);
        if (!(direction.explained() > kNothingLeft * first_energy)) direction = {};
        residual.subtract(direction);
        const int center =
            direction.places.empty() ? strongest : residual.longest_vertex(direction);
        found.add(residual, direction, {center, everything});
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

/// The places among `vertices` that are nearer than `reach`, rising.
std::vector<int> nearer_places(std::span<const int> vertices, std::span<const double> distances,
                               double reach) {
    std::vector<int> places;
    for (std::size_t n = 0; n < vertices.size(); ++n) {
        if (distances[at(vertices[n])] < reach) places.push_back(static_cast<int>(n));
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
    const double first_energy = residual.energy();
    std::vector<int> everything(at(vertices));
    std::iota(everything.begin(), everything.end(), 0);
    Found found;
    find_global(settings.global_components, first_energy, residual, everything, found);
    Crowds crowds(settings.spread, vertices);
    const std::vector<int> candidates = spread_vertices(distances, kCandidates);
    for (const BallLevel& level : settings.levels) {
        const auto within_reach = [&](int center, std::span<const int> of) {
            const std::span<const double> row = distances.row(center);
            return nearer_places(of, row, reach_of(row, level.sparsity_range, level.max_support));
        };
        Deflation deflation(residual, first_energy, distances, within_reach, candidates);
        for (int k = 0; k < level.components; ++k) {
            const FoundComponent next = deflation.next([&](int v) { return crowds.is_crowded(v); });
            crowds.add(distances.row(next.center));
            found.add(residual, next.direction,
                      {next.center, within_reach(next.center, everything)});
        }
    }
    BallComponents components(vertices, std::move(found.balls));
    for (int k = 0; k < components.count(); ++k) components.set_component(k, found.values[at(k)]);
    return components;
}

}  // namespace mscomp

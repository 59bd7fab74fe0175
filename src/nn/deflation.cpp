// SPDX-License-Identifier: MIT
#include "deflation.h"

#include <algorithm>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "nn/dim.h"

namespace mscomp::nn {
namespace {

constexpr std::size_t kMostShapes = 256;

/// Where a component can start: vertices and what lies within their reach.
struct Candidate {
    int center;
    std::vector<int> places;
};

double energy_within(const DeflationResidual& residual, std::span<const int> places) {
    double sum = 0;
    for (const int place : places) sum += residual.energies()[at(place)];
    return sum;
}

int strongest_center(const DeflationResidual& residual, const std::vector<Candidate>& candidates,
                     const FreePlaces& free_places) {
    int best = residual.strongest_vertex();
    double most = energy_within(residual, free_places(best, residual.vertices()));
    for (const Candidate& candidate : candidates) {
        const double energy = energy_within(residual, candidate.places);
        if (!(energy > most)) continue;
        most = energy;
        best = candidate.center;
    }
    return best;
}

FoundComponent next_component(const DeflationResidual& residual, DistanceRows& distances,
                              const FreePlaces& free_places, int center) {
    constexpr int kMoves = 6;
    FoundComponent best;
    for (int move = 0; move < kMoves; ++move) {
        FoundComponent found;
        found.center = center;
        // Rows of earlier centres need not be kept.
        distances.prepare(std::span(&center, 1));
        found.direction = residual.main_direction(center, free_places(center, residual.vertices()));
        found.energy = found.direction.explained();
        if (!(found.energy > best.energy)) break;
        best = std::move(found);
        center = residual.longest_vertex(best.direction);
        if (center == best.center) break;
    }
    return best;
}

}  // namespace

StartShapes::StartShapes(const ScaledFeatures& all, std::span<const int> which, int most)
    : features(all), batch(at(most)) {
    const std::size_t wanted = std::min(which.size(), kMostShapes);
    for (std::size_t i = 0; i < wanted; ++i) shapes.push_back(which[i * which.size() / wanted]);
}

std::span<const int> StartShapes::pass(std::size_t first) const {
    return std::span(shapes).subspan(first, std::min(batch, shapes.size() - first));
}

std::vector<int> spread_vertices(DistanceRows& distances, int most) {
    std::vector<double> nearest(at(distances.vertex_count()), 2.0);
    std::vector<int> chosen{0};
    while (static_cast<int>(chosen.size()) < std::min(most, distances.vertex_count())) {
        distances.prepare(std::span(&chosen.back(), 1));
        const std::span<const double> row = distances.row(chosen.back());
        for (std::size_t v = 0; v < nearest.size(); ++v) nearest[v] = std::min(nearest[v], row[v]);
        chosen.push_back(static_cast<int>(std::ranges::max_element(nearest) - nearest.begin()));
    }
    return chosen;
}

std::vector<FoundComponent> deflate(DeflationResidual& residual, int components,
                                    DistanceRows& distances, const FreePlaces& free_places,
                                    std::span<const int> candidates) {
    // Below this part of the first energy there is only rounding left.
    constexpr double kNothingLeft = 1e-10;
    const double first_energy = residual.energy();
    std::vector<Candidate> spread;
    for (const int center : candidates) {
        spread.push_back({center, free_places(center, residual.vertices())});
    }
    std::vector<FoundComponent> all;
    for (int k = 0; k < components; ++k) {
        FoundComponent found = next_component(residual, distances, free_places,
                                              strongest_center(residual, spread, free_places));
        if (found.energy > kNothingLeft * first_energy) {
            residual.subtract(found.direction);
        } else {
            found.direction = {};
        }
        all.push_back(std::move(found));
    }
    return all;
}

template <class T>
void write_direction(const DeflationResidual& residual, const DeflationDirection& direction,
                     std::int64_t width, std::span<T> row) {
    for (std::size_t place = 0; place < direction.places.size(); ++place) {
        const int v = residual.vertices()[at(direction.places[place])];
        for (std::int64_t c = 0; c < std::min(width, kDim); ++c) {
            row[at(v * width + c)] = static_cast<T>(direction.values[place * at(kDim) + at(c)]);
        }
    }
}

template void write_direction(const DeflationResidual&, const DeflationDirection&, std::int64_t,
                              std::span<float>);
template void write_direction(const DeflationResidual&, const DeflationDirection&, std::int64_t,
                              std::span<double>);

}  // namespace mscomp::nn

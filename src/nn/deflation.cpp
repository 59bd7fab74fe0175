// SPDX-License-Identifier: MIT
#include "deflation.h"

#include <algorithm>
#include <utility>

#include "mscomp/base/feature_set.h"

namespace mscomp::nn {
namespace {

constexpr std::int64_t kDim = kFeatureDim;
constexpr std::size_t kMostShapes = 256;

std::size_t at(std::int64_t index) { return static_cast<std::size_t>(index); }

FoundComponent next_component(const DeflationResidual& residual, DistanceRows& distances,
                              const FreePlaces& free_places) {
    constexpr int kMoves = 6;
    FoundComponent best;
    int center = residual.strongest_vertex();
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
    : features(all), batch(static_cast<std::size_t>(most)) {
    const std::size_t wanted = std::min(which.size(), kMostShapes);
    for (std::size_t i = 0; i < wanted; ++i) shapes.push_back(which[i * which.size() / wanted]);
}

std::span<const int> StartShapes::pass(std::size_t first) const {
    return std::span(shapes).subspan(first, std::min(batch, shapes.size() - first));
}

std::vector<FoundComponent> deflate(DeflationResidual& residual, int components,
                                    DistanceRows& distances, const FreePlaces& free_places) {
    // Below this part of the first energy there is only rounding left.
    constexpr double kNothingLeft = 1e-10;
    const double first_energy = residual.energy();
    std::vector<FoundComponent> all;
    for (int k = 0; k < components; ++k) {
        FoundComponent found = next_component(residual, distances, free_places);
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

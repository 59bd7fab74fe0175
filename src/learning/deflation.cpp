// SPDX-License-Identifier: MIT
#include "learning/deflation.h"

#include <algorithm>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

double energy_within(const DeflationResidual& residual, std::span<const int> places) {
    double sum = 0;
    for (const int place : places) sum += residual.energies()[at(place)];
    return sum;
}

}  // namespace

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

Deflation::Deflation(DeflationResidual& residual, double first_energy, DistanceRows& distances,
                     FreePlaces free_places, std::span<const int> candidates)
    : residual_(residual),
      distances_(distances),
      free_places_(std::move(free_places)),
      first_energy_(first_energy) {
    for (const int center : candidates) {
        candidates_.push_back({center, free_places_(center, residual.vertices())});
    }
}

int Deflation::strongest_center(const IsCrowded& is_crowded) const {
    int best = residual_.strongest_vertex();
    double most = energy_within(residual_, free_places_(best, residual_.vertices()));
    if (is_crowded && is_crowded(best)) most = -1;
    for (const Candidate& candidate : candidates_) {
        const double energy = energy_within(residual_, candidate.places);
        if (!(energy > most) || (is_crowded && is_crowded(candidate.center))) continue;
        most = energy;
        best = candidate.center;
    }
    return best;
}

FoundComponent Deflation::around(int center, const IsCrowded& is_crowded) const {
    constexpr int kMoves = 6;
    FoundComponent best;
    for (int move = 0; move < kMoves; ++move) {
        FoundComponent found;
        found.center = center;
        // Rows of earlier centres need not be kept.
        distances_.prepare(std::span(&center, 1));
        found.direction =
            residual_.main_direction(center, free_places_(center, residual_.vertices()));
        found.energy = found.direction.explained();
        if (!(found.energy > best.energy)) break;
        best = std::move(found);
        center = residual_.longest_vertex(best.direction);
        if (center == best.center || (is_crowded && is_crowded(center))) break;
    }
    return best;
}

FoundComponent Deflation::next(const IsCrowded& is_crowded) {
    FoundComponent found = around(strongest_center(is_crowded), is_crowded);
    if (found.energy > kNothingLeft * first_energy_) {
        residual_.subtract(found.direction);
    } else {
        found.direction = {};
    }
    return found;
}

std::vector<FoundComponent> deflate(DeflationResidual& residual, int components,
                                    DistanceRows& distances, const FreePlaces& free_places,
                                    std::span<const int> candidates) {
    Deflation deflation(residual, residual.energy(), distances, free_places, candidates);
    std::vector<FoundComponent> all;
    for (int k = 0; k < components; ++k) all.push_back(deflation.next());
    return all;
}

template <class T>
void write_direction(const DeflationResidual& residual, const DeflationDirection& direction,
                     std::int64_t width, std::span<T> row) {
    for (std::size_t place = 0; place < direction.places.size(); ++place) {
        const int v = residual.vertices()[at(direction.places[place])];
        for (std::int64_t c = 0; c < std::min(width, kRowDim); ++c) {
            row[at(v * width + c)] = static_cast<T>(direction.values[place * at(kRowDim) + at(c)]);
        }
    }
}

template void write_direction(const DeflationResidual&, const DeflationDirection&, std::int64_t,
                              std::span<float>);
template void write_direction(const DeflationResidual&, const DeflationDirection&, std::int64_t,
                              std::span<double>);

}  // namespace mscomp

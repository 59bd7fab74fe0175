// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/geodesic/heat_geodesics.h"

namespace mscomp {
namespace {

using Row = std::vector<double>;
using SourceSets = std::vector<std::vector<int>>;

/// Rows held in memory at once while looking for the largest distance.
constexpr std::size_t kRowsAtOnce = 256;
/// Sweeps stop growing after two or three; the rest is for awkward shapes.
constexpr std::size_t kSweeps = 8;
constexpr int kFarthestPoints = 24;

double largest_finite(const Row& row) {
    double largest = 0;
    for (const double distance : row) {
        if (std::isfinite(distance)) largest = std::max(largest, distance);
    }
    return largest;
}

/// Components do not see each other, so set r takes the r-th vertex of every component at once.
SourceSets all_vertices(std::span<const int> components) {
    SourceSets sets;
    std::vector<std::size_t> seen(components.size(), 0);
    for (std::size_t i = 0; i < components.size(); ++i) {
        const std::size_t round = seen[at(components[i])]++;
        if (round == sets.size()) sets.emplace_back();
        sets[round].push_back(static_cast<int>(i));
    }
    return sets;
}

double exact_largest(const HeatGeodesics& geodesics) {
    const SourceSets sets = all_vertices(geodesics.components());
    double largest = 0;
    for (std::size_t begin = 0; begin < sets.size(); begin += kRowsAtOnce) {
        const std::size_t count = std::min(kRowsAtOnce, sets.size() - begin);
        for (const Row& row : geodesics.distance_rows(std::span(sets).subspan(begin, count))) {
            largest = std::max(largest, largest_finite(row));
        }
    }
    return largest;
}

/// In every component the vertex with the largest entry, the lowest on ties.
std::vector<int> farthest_in_each(const Row& row, std::span<const int> components) {
    std::vector<int> farthest;
    for (std::size_t i = 0; i < row.size(); ++i) {
        const auto component = at(components[i]);
        if (component == farthest.size()) {
            farthest.push_back(static_cast<int>(i));
        } else if (row[i] > row[at(farthest[component])]) {
            farthest[component] = static_cast<int>(i);
        }
    }
    return farthest;
}

double swept_largest(const HeatGeodesics& geodesics) {
    const std::span<const int> components = geodesics.components();
    double largest = 0;
    Row nearest(components.size(), std::numeric_limits<double>::infinity());
    const auto row_from = [&](std::vector<int> sources) {
        Row row = std::move(geodesics.distance_rows(SourceSets{std::move(sources)}).front());
        largest = std::max(largest, largest_finite(row));
        for (std::size_t i = 0; i < row.size(); ++i) nearest[i] = std::min(nearest[i], row[i]);
        return row;
    };
    std::vector<int> sources = farthest_in_each(Row(components.size(), 0.0), components);
    SourceSets seen;
    // Sources that come again would only bring the same rows again.
    while (seen.size() < kSweeps && std::ranges::find(seen, sources) == seen.end()) {
        seen.push_back(sources);
        sources = farthest_in_each(row_from(sources), components);
    }
    for (int i = 0; i < kFarthestPoints; ++i) row_from(farthest_in_each(nearest, components));
    return largest;
}

}  // namespace

GeodesicNormalizer geodesic_normalizer(const HeatGeodesics& geodesics, int exact_limit) {
    if (geodesics.vertex_count() == 0) return {0, true};
    if (geodesics.vertex_count() <= exact_limit) return {exact_largest(geodesics), true};
    return {swept_largest(geodesics), false};
}

NormalizedGeodesics::NormalizedGeodesics(HeatGeodesics geodesics, double largest_distance,
                                         std::size_t cache_bytes)
    : geodesics_(std::move(geodesics)), largest_distance_(largest_distance), cache_(cache_bytes) {
    if (!(largest_distance >= 0) || !std::isfinite(largest_distance)) {
        throw NumericalError(fmt::format(
            "geodesics: the normaliser is {}, wanted a finite distance >= 0", largest_distance));
    }
}

std::span<const double> NormalizedGeodesics::store(int vertex, Row distances) {
    for (double& distance : distances) {
        // Where all distances are 0 so is the normaliser: 0, not 0 / 0.
        if (distance > 0) distance = std::min(distance / largest_distance_, 1.0);
    }
    return cache_.put(vertex, std::move(distances));
}

void NormalizedGeodesics::prepare(std::span<const int> vertices) {
    cache_.start_round();
    std::vector<int> missing;
    for (const int vertex : vertices) {
        if (!cache_.find(vertex)) missing.push_back(vertex);
    }
    std::sort(missing.begin(), missing.end());
    missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
    std::vector<Row> computed = geodesics_.distance_rows(missing);
    for (std::size_t k = 0; k < missing.size(); ++k) store(missing[k], std::move(computed[k]));
}

std::span<const double> NormalizedGeodesics::row(int vertex) {
    if (const auto known = cache_.find(vertex)) return *known;
    return store(vertex, geodesics_.distances(vertex));
}

}  // namespace mscomp

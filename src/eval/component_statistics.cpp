// SPDX-License-Identifier: MIT
#include "mscomp/eval/component_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

void check(std::span<const std::span<const float>> differences, std::span<const int> centers,
           int vertices) {
    if (differences.size() != centers.size()) {
        throw UsageError(fmt::format("component statistics: {} components with {} centres",
                                     differences.size(), centers.size()));
    }
    for (std::size_t k = 0; k < differences.size(); ++k) {
        const std::size_t size = differences[k].size();
        if (size == 0 || vertices <= 0 || size != differences.front().size() ||
            size % at(vertices) != 0) {
            throw UsageError(fmt::format(
                "component statistics: component {} has {} values, the first {}, the mesh {} "
                "vertices; wanted the same multiple of the vertices for all",
                k, size, differences.front().size(), vertices));
        }
        if (centers[k] < 0 || centers[k] >= vertices) {
            throw UsageError(
                fmt::format("component statistics: component {} has centre {}, wanted 0 to {}", k,
                            centers[k], vertices - 1));
        }
    }
}

ComponentExtent extent_of(std::span<const float> difference, std::span<const double> distance,
                          double threshold) {
    const std::size_t channels = difference.size() / distance.size();
    ComponentExtent extent;
    for (std::size_t i = 0; i < distance.size(); ++i) {
        double square = 0;
        for (const float x : difference.subspan(i * channels, channels)) {
            square += static_cast<double>(x) * static_cast<double>(x);
        }
        // Written so that NaN counts as acting.
        if (square == 0) continue;
        ++extent.support;
        if (std::sqrt(square) <= threshold) continue;
        extent.localization_radius = std::max(extent.localization_radius, distance[i]);
    }
    extent.support_share =
        static_cast<double>(extent.support) / static_cast<double>(distance.size());
    return extent;
}

double dot(std::span<const float> a, std::span<const float> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum += static_cast<double>(a[i]) * static_cast<double>(b[i]);
    }
    return sum;
}

std::vector<double> cosines(std::span<const std::span<const float>> rows) {
    const std::size_t count = rows.size();
    std::vector<double> norms, result(count * count, 1);
    for (const auto& row : rows) norms.push_back(std::sqrt(dot(row, row)));
    parallel_for(static_cast<std::int64_t>(count), [&](std::int64_t index) {
        const auto k = at(index);
        for (std::size_t l = 0; l < count; ++l) {
            if (l == k && std::isfinite(norms[k])) continue;
            const double size = norms[k] * norms[l];
            result[k * count + l] = size == 0 ? 0 : dot(rows[k], rows[l]) / size;
        }
    });
    return result;
}

}  // namespace

ComponentCosines component_cosines(std::span<const std::span<const float>> differences) {
    const std::size_t count = differences.size();
    ComponentCosines result;
    result.cosine = cosines(differences);
    double sum = 0;
    for (std::size_t k = 0; k < count; ++k) {
        for (std::size_t l = 0; l < count; ++l) {
            if (l == k) continue;
            const double size = std::abs(result.cosine[k * count + l]);
            sum += size;
            // std::max would forget a NaN.
            if (!(size <= result.cosine_max)) result.cosine_max = size;
        }
    }
    if (count > 1) result.cosine_mean = sum / static_cast<double>(count * (count - 1));
    if (std::isnan(sum)) result.cosine_max = sum;
    return result;
}

ComponentStatistics component_statistics(std::span<const std::span<const float>> differences,
                                         std::span<const int> centers, DistanceRows& distances,
                                         double threshold) {
    check(differences, centers, distances.vertex_count());
    ComponentStatistics statistics;
    static_cast<ComponentCosines&>(statistics) = component_cosines(differences);
    const std::size_t count = differences.size();
    distances.prepare(centers);
    for (std::size_t k = 0; k < count; ++k) {
        statistics.components.push_back(
            extent_of(differences[k], distances.row(centers[k]), threshold));
        statistics.support_mean +=
            statistics.components.back().support_share / static_cast<double>(count);
    }
    return statistics;
}

}  // namespace mscomp

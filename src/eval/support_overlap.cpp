// SPDX-License-Identifier: MIT
#include "mscomp/eval/support_overlap.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/eval/unit_matches.h"

namespace mscomp {
namespace {

/// 0 where one of them is not finite: then there is nothing to compare with.
double largest_strength(std::span<const double> strength) {
    double largest = 0;
    for (const double x : strength) {
        if (!std::isfinite(x)) return 0;
        largest = std::max(largest, x);
    }
    return largest;
}

/// Of an even number of values the lower one in the middle.
float median(std::vector<float>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Median rotation vector of the vertices that rest; zero where none does.
std::array<float, kRotationDim> rotation_of_rest(std::span<const float> change,
                                                 std::span<const char> rests) {
    std::array<float, kRotationDim> rotation{};
    std::vector<float> values;
    for (std::size_t c = 0; c < rotation.size(); ++c) {
        values.clear();
        for (std::size_t v = 0; v < rests.size(); ++v) {
            if (rests[v] != 0) values.push_back(change[v * kFeatureDim + c]);
        }
        if (!values.empty()) rotation[c] = median(values);
    }
    return rotation;
}

void require_sizes(bool fit, std::size_t got, std::size_t wanted) {
    if (fit) return;
    throw UsageError(fmt::format("overlap of supports: {} numbers, wanted {}", got, wanted));
}

}  // namespace

std::vector<char> support_of(std::span<const double> strength, double threshold) {
    const double largest = largest_strength(strength);
    std::vector<char> support(strength.size(), 0);
    for (std::size_t v = 0; largest > 0 && v < strength.size(); ++v) {
        support[v] = strength[v] > threshold * largest ? 1 : 0;
    }
    return support;
}

std::vector<double> change_lengths(std::span<const float> change, std::span<const char> rests) {
    const std::size_t wanted = rests.size() * kFeatureDim;
    require_sizes(change.size() == wanted, change.size(), wanted);
    const std::array<float, kRotationDim> rest = rotation_of_rest(change, rests);
    std::vector<double> lengths;
    lengths.reserve(rests.size());
    for (std::size_t v = 0; v < rests.size(); ++v) {
        const std::span<const float> row = change.subspan(v * kFeatureDim, kFeatureDim);
        double squares = 0;
        for (std::size_t c = 0; c < row.size(); ++c) {
            double x = static_cast<double>(row[c]);
            if (c < rest.size()) x -= static_cast<double>(rest[c]);
            squares += x * x;
        }
        lengths.push_back(std::sqrt(squares));
    }
    return lengths;
}

SupportOverlap support_overlap(std::span<const double> found, std::span<const double> truth,
                               double threshold) {
    require_sizes(found.size() == truth.size(), found.size(), truth.size());
    const double most_found = largest_strength(found), most_true = largest_strength(truth);
    if (!(most_found > 0 && most_true > 0)) return {};
    double both = 0, either = 0, least = 0, most = 0;
    for (std::size_t v = 0; v < found.size(); ++v) {
        const double a = found[v] / most_found, b = truth[v] / most_true;
        both += a > threshold && b > threshold ? 1 : 0;
        either += a > threshold || b > threshold ? 1 : 0;
        least += std::min(a, b);
        most += std::max(a, b);
    }
    return {both / either, least / most};
}

SupportMatches support_matches(std::span<const std::span<const float>> changes,
                               std::span<const float> supports, int vertex_count,
                               double threshold) {
    const std::size_t width = at(vertex_count);
    require_sizes(width > 0 && supports.size() % width == 0, supports.size(), width);
    SupportMatches matches;
    matches.component_count = static_cast<int>(changes.size());
    matches.truth_count = static_cast<int>(supports.size() / width);
    const auto truths = at(matches.truth_count);
    std::vector<std::vector<double>> strengths;
    std::vector<std::vector<char>> rests;
    for (std::size_t u = 0; u < truths; ++u) {
        const std::span<const float> row = supports.subspan(u * width, width);
        strengths.emplace_back(row.begin(), row.end());
        rests.push_back(support_of(strengths.back(), threshold));
        for (char& each : rests.back()) each = each != 0 ? 0 : 1;
    }
    matches.overlaps.resize(changes.size() * truths);
    parallel_for(matches.component_count, [&](std::int64_t k) {
        for (std::size_t u = 0; u < truths; ++u) {
            matches.overlaps[at(k) * truths + u] =
                support_overlap(change_lengths(changes[at(k)], rests[u]), strengths[u], threshold);
        }
    });
    std::vector<double> table;
    for (const SupportOverlap& overlap : matches.overlaps) table.push_back(overlap.iou);
    matches.one_to_one = greedy_pairs(table, matches.component_count, matches.truth_count);
    return matches;
}

}  // namespace mscomp

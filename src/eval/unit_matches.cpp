// SPDX-License-Identifier: MIT
#include "mscomp/eval/unit_matches.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

/// Columns with mean 0 and length 1; zero where they are constant or not finite.
std::vector<std::vector<double>> normalized_columns(std::span<const double> table, int rows) {
    const auto n = at(rows);
    const std::size_t width = table.size() / n;
    std::vector<std::vector<double>> columns(width, std::vector<double>(n));
    for (std::size_t c = 0; c < width; ++c) {
        std::vector<double>& column = columns[c];
        for (std::size_t r = 0; r < n; ++r) column[r] = table[r * width + c];
        const auto [low, high] = std::ranges::minmax(column);
        double mean = 0, squares = 0;
        for (const double x : column) mean += x / static_cast<double>(n);
        for (double& x : column) {
            x -= mean;
            squares += x * x;
        }
        // Compared before the mean is taken off: rounding must not make a constant vary.
        const bool varies = low != high && squares > 0 && std::isfinite(squares);
        const double length = std::sqrt(squares);
        for (double& x : column) x = varies ? x / length : 0;
    }
    return columns;
}

void check(std::span<const double> codes, std::span<const double> weights, int shapes) {
    const auto fits = [shapes](std::span<const double> table) {
        return shapes > 0 && table.size() % at(shapes) == 0;
    };
    if (!fits(codes) || !fits(weights)) {
        throw UsageError(
            fmt::format("correlations: {} codes and {} true weights for {} shapes; wanted as many "
                        "for every shape, and at least one shape",
                        codes.size(), weights.size(), shapes));
    }
}

std::vector<UnitMatch> best_codes(const UnitMatches& matches) {
    std::vector<UnitMatch> best(at(matches.unit_count));
    for (int u = 0; u < matches.unit_count; ++u) {
        UnitMatch& match = best[at(u)];
        for (int k = 0; k < matches.code_count; ++k) {
            if (match.code >= 0 && matches.at(k, u) <= match.correlation) continue;
            match = {k, matches.at(k, u)};
        }
    }
    return best;
}

std::vector<UnitMatch> one_to_one_of(const UnitMatches& matches) {
    const std::vector<int> pairs =
        greedy_pairs(matches.correlation, matches.code_count, matches.unit_count);
    std::vector<UnitMatch> result(pairs.size());
    for (std::size_t u = 0; u < pairs.size(); ++u) {
        if (pairs[u] >= 0) result[u] = {pairs[u], matches.at(pairs[u], static_cast<int>(u))};
    }
    return result;
}

int count_reaching(const std::vector<UnitMatch>& matches, double threshold) {
    return static_cast<int>(std::ranges::count_if(matches, [threshold](const UnitMatch& match) {
        return match.code >= 0 && match.correlation >= threshold;
    }));
}

}  // namespace

std::vector<int> greedy_pairs(std::span<const double> table, int rows, int columns) {
    std::vector<int> pairs(at(columns), -1);
    std::vector<bool> is_taken(at(rows));
    const auto entry = [&](int row, int column) {
        return table[at(row) * at(columns) + at(column)];
    };
    for (int round = 0; round < std::min(rows, columns); ++round) {
        int best_column = -1, best_row = -1;
        for (int column = 0; column < columns; ++column) {
            if (pairs[at(column)] >= 0) continue;
            for (int row = 0; row < rows; ++row) {
                if (is_taken[at(row)]) continue;
                if (best_column >= 0 && entry(row, column) <= entry(best_row, best_column))
                    continue;
                best_column = column;
                best_row = row;
            }
        }
        pairs[at(best_column)] = best_row;
        is_taken[at(best_row)] = true;
    }
    return pairs;
}

UnitMatches correlation_table(std::span<const double> codes, std::span<const double> weights,
                              int shape_count, double threshold) {
    check(codes, weights, shape_count);
    const auto code_columns = normalized_columns(codes, shape_count);
    const auto unit_columns = normalized_columns(weights, shape_count);
    UnitMatches matches;
    matches.code_count = static_cast<int>(code_columns.size());
    matches.unit_count = static_cast<int>(unit_columns.size());
    for (const auto& code : code_columns) {
        for (const auto& unit : unit_columns) {
            double sum = 0;
            for (std::size_t r = 0; r < code.size(); ++r) sum += code[r] * unit[r];
            matches.correlation.push_back(std::min(std::abs(sum), 1.0));
        }
    }
    matches.best = best_codes(matches);
    matches.matched = count_reaching(matches.best, threshold);
    matches.one_to_one = one_to_one_of(matches);
    matches.matched_one_to_one = count_reaching(matches.one_to_one, threshold);
    return matches;
}

}  // namespace mscomp

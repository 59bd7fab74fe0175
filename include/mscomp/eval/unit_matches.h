// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

namespace mscomp {

/// A code that goes with a true unit, and |Pearson correlation| over the shapes.
struct UnitMatch {
    int code = -1;  // -1: none
    double correlation = 0;
};

/// How well codes of n shapes tell true weights of the same shapes (known units of a generated or
/// posed set, such as expression weights or joint angles).
struct UnitMatches {
    int code_count = 0, unit_count = 0;
    std::vector<double> correlation;  // (K,U) absolute, row-major

    std::vector<UnitMatch> best;  // (U) the best code of each unit; a code may serve several units
    int matched = 0;              // units whose best reaches the threshold
    /// (U) the largest entry of the table, then the largest without its row and column, and so on:
    /// every code serves one unit; none for the units left over where U > K. Of equals the lower
    /// unit, then the lower code.
    std::vector<UnitMatch> one_to_one;
    int matched_one_to_one = 0;

    double at(int code, int unit) const {
        return correlation[static_cast<std::size_t>(code) * static_cast<std::size_t>(unit_count) +
                           static_cast<std::size_t>(unit)];
    }
};

/// Pairs of the rows and columns of a table (K,U), row-major, of how well they go together: the row
/// of each column, -1 where K < U leaves none. The largest entry, then the largest without its row
/// and column, and so on; of equals the lower column, then the lower row.
std::vector<int> greedy_pairs(std::span<const double> table, int rows, int columns);

/// Correlations of `codes` (n,K) with true `weights` (n,U), row-major, for n = `shape_count`:
///     |Σ (z - mean z)(w - mean w)| / sqrt(Σ (z - mean z)^2 Σ (w - mean w)^2).
/// Scale, offset and sign of a code do not matter. A column that is the same for all shapes, or has
/// a number that is not finite, correlates 0. Throws UsageError for sizes that do not fit.
UnitMatches correlation_table(std::span<const double> codes, std::span<const double> weights,
                              int shape_count, double threshold = 0.9);

}  // namespace mscomp

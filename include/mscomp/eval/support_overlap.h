// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

namespace mscomp {

/// Part of its own largest strength from which on a component counts as present at a vertex,
/// whether it is true or found.
inline constexpr double kSupportThreshold = 0.1;

/// (V) 1 where a strength (V) exceeds `threshold` times the largest; nowhere where all are 0 or one
/// is not finite.
std::vector<char> support_of(std::span<const double> strength,
                             double threshold = kSupportThreshold);

/// Lengths (V) of a change of features (V,9), less the rotation that the vertices `rests` (V) have
/// on average: |(r_v - median r, S_v)|, channel by channel over those where it is not 0. Turned as
/// a whole a shape is the same shape; which of its parts then lies still is a convention.
std::vector<double> change_lengths(std::span<const float> change, std::span<const char> rests);

/// How far two strengths (V) a, b of one mesh lie at the same vertices; 0 to 1, 1: the same.
struct SupportOverlap {
    double iou = 0;       // of their supports: vertices of both over vertices of either
    double soft_iou = 0;  // Σ min(a', b') / Σ max(a', b'), each in parts of its own largest
};

/// Both 0 where one of them has no support. Throws UsageError for sizes that do not fit.
SupportOverlap support_overlap(std::span<const double> found, std::span<const double> truth,
                               double threshold = kSupportThreshold);

/// What lies where.
struct SupportMatches {
    int component_count = 0, truth_count = 0;
    std::vector<SupportOverlap> overlaps;  // (K,U) row-major
    /// (U) the component of each truth, -1 where K < U leaves none: the largest IoU of the table,
    /// then the largest without its row and column, and so on (greedy_pairs).
    std::vector<int> one_to_one;

    const SupportOverlap& at(int component, int truth) const {
        return overlaps[static_cast<std::size_t>(component) *
                            static_cast<std::size_t>(truth_count) +
                        static_cast<std::size_t>(truth)];
    }
};

/// Components, found as changes of features (V,9) from the reference, beside true `supports` (U,V)
/// on the same vertices, which say how much of a true component reaches each vertex. For each pair
/// what rests in the truth rests in the component (change_lengths). The same bits for any number of
/// threads. Throws UsageError for sizes that do not fit.
SupportMatches support_matches(std::span<const std::span<const float>> changes,
                               std::span<const float> supports, int vertex_count,
                               double threshold = kSupportThreshold);

}  // namespace mscomp

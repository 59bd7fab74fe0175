// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "mscomp/base/distance_rows.h"

namespace mscomp {

/// Where one component acts. |D_i| is the length of its difference at vertex i, over the channels.
struct ComponentExtent {
    int support = 0;                 // vertices with |D_i| > 0
    double support_share = 0;        // of all vertices
    double localization_radius = 0;  // largest distance from the centre where |D_i| > threshold
};

/// How alike K components are.
struct ComponentCosines {
    std::vector<double> cosine;  // (K,K) <D_k, D_l> / (|D_k| |D_l|), row-major
    double cosine_mean = 0;      // mean and largest of |cosine| off the diagonal;
    double cosine_max = 0;       // 0 for fewer than two components
};

/// Extents of K components and how alike they are.
struct ComponentStatistics : ComponentCosines {
    std::vector<ComponentExtent> components;  // (K)
    double support_mean = 0;                  // mean of support_share
};

/// The cosines of `differences` alone, as below; spans of one length.
ComponentCosines component_cosines(std::span<const std::span<const float>> differences);

/// Statistics of components given by what they add to the features of the reference,
/// `differences` (K) spans of (V,C) values each with C the same for all (9 for ACAP features), and
/// their `centers` (K). `distances` are normalised geodesic distances in the same vertex order,
/// `threshold` is in the unit of the differences. A component that is zero has cosine 0 with every
/// other and 1 with itself, and radius 0; a value that is not finite counts as support and makes
/// its cosines NaN. Throws UsageError for sizes or centres that do not fit.
ComponentStatistics component_statistics(std::span<const std::span<const float>> differences,
                                         std::span<const int> centers, DistanceRows& distances,
                                         double threshold = 0);

}  // namespace mscomp

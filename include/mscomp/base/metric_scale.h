// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"

namespace mscomp {

/// The map of features (V,9) to what a model works on, affine per channel and times the root of
/// what a squared error counts at the vertex: scaled = (feature - offset) * factor * root. By
/// default features stay as they are. A factor of 0 is for channels that do not vary: they scale to
/// 0 and come back as the offset.
struct MetricScale {
    std::array<double, kFeatureDim> offset{};
    std::array<double, kFeatureDim> factor{1, 1, 1, 1, 1, 1, 1, 1, 1};
    std::vector<float> roots{};  // (V), positive; empty: 1 at every vertex

    double root(std::size_t v) const { return roots.empty() ? 1 : static_cast<double>(roots[v]); }
    /// What a scaled value changes by where its feature changes by 1.
    double scale_factor(std::size_t v, std::size_t channel) const {
        return factor[channel] * root(v);
    }
    /// What a feature changes by where its scaled value changes by 1.
    double unscale_factor(std::size_t v, std::size_t channel) const {
        return factor[channel] != 0 ? 1 / (factor[channel] * root(v)) : 0;
    }

    /// In place over the rows of the vertices 0, 1, ...; in double, rounded to float once.
    void scale(std::span<float> features) const;
    void unscale(std::span<float> features) const;
    /// Nine scaled values of vertex v as a difference of features, in place.
    void unscale_change(int v, std::span<float> values) const;
};

}  // namespace mscomp

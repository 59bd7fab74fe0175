// SPDX-License-Identifier: MIT
// What the tests against the independent float64 program share.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "mscomp/base/distance_rows.h"

namespace mscomp::nn {

constexpr double kTolerance = 1e-9;

/// Distances from a table (V,V).
class StoredDistances final : public DistanceRows {
  public:
    StoredDistances(std::span<const double> table, int vertices)
        : table_(table), vertices_(vertices) {}
    int vertex_count() const override { return vertices_; }
    std::span<const double> row(int vertex) override {
        return table_.subspan(
            static_cast<std::size_t>(vertex) * static_cast<std::size_t>(vertices_),
            static_cast<std::size_t>(vertices_));
    }

  private:
    std::span<const double> table_;
    int vertices_;
};

/// Largest |got - expected| relative to the largest |expected| of the array; NaN comes through.
inline double relative_error(std::span<const double> got, std::span<const double> expected) {
    if (got.size() != expected.size()) return std::nan("");
    double worst = 0, scale = 0;
    for (std::size_t i = 0; i < got.size(); ++i) {
        scale = std::max(scale, std::abs(expected[i]));
        const double error = std::abs(got[i] - expected[i]);
        if (!(error <= worst)) worst = error;
    }
    return scale > 0 ? worst / scale : worst;
}

}  // namespace mscomp::nn

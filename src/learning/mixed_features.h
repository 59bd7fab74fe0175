// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/made_rows.h"
#include "mscomp/base/shape_features.h"

namespace mscomp {

/// Features, and behind them any number of shapes mixed from some of them: the surface falls into 4
/// to 40 patches around spread vertices, every patch follows one shape drawn at random, and between
/// patches they blend, w_p ~ exp(-d_p / 0.05) in the normalised distance d_p from the middle of
/// patch p. What far parts of a body do together in a few shapes is taken apart, so that a model
/// cannot learn it. A part of the patches may follow two shapes, a + t (b - a) with t drawn from
/// [-0.1, 1.1] (method §9). Mixed shape m is number shape_count() + m, a function of the seed and
/// m.
class MixedFeatures final : public ShapeFeatures {
  public:
    /// Borrows `features` and, here only, `distances`, whose vertex i is
    /// vertex to_user[i] of the features; mixes `shapes` of them, at least one. `between` is
    /// the part of the patches that follow two.
    MixedFeatures(const ShapeFeatures& features, std::span<const int> shapes,
                  DistanceRows& distances, std::span<const int> to_user, std::uint64_t seed,
                  double between = 0);

    int shape_count() const override { return features_.shape_count(); }
    int vertex_count() const override { return features_.vertex_count(); }
    /// Rows of mixed shapes are made when they are asked for and kept until forgotten. Safe to call
    /// from several threads for different shapes.
    std::span<const float> shape(int index) const override;
    void forget(int index) const override;

    /// The shapes that the P patches of a mixed shape follow, those that they go some way to, and
    /// the weights (V,P) of the patches, which sum to 1 at every vertex.
    struct Mix {
        std::vector<int> shapes;
        std::vector<int> others;  // (P), the same where a patch follows one shape
        std::vector<float> ways;  // (P) t
        std::vector<float> weights;
    };
    Mix mix(int m) const;

  private:
    std::vector<float> mixed_row(int m) const;

    const ShapeFeatures& features_;
    std::vector<int> shapes_;
    std::uint64_t seed_;
    double between_;
    std::vector<std::vector<float>> middles_;  // distances from each, (V)
    mutable MadeRows rows_;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "code_trials.h"
#include "mscomp/base/channel_scale.h"
#include "mscomp/model/shape_model.h"

namespace mscomp {

/// How differences of features count: their mean square after every entry is multiplied by the
/// factor of its channel and the root of the weight of its vertex.
class FeatureNorm {
  public:
    /// `weights` (V), none below 0; empty: 1 each.
    FeatureNorm(const ChannelScale& scale, std::span<const float> weights);

    double factor(int vertex, std::size_t channel) const {
        const double factor = factors_[channel];
        return roots_.empty() ? factor : factor * roots_[static_cast<std::size_t>(vertex)];
    }

  private:
    std::array<double, kFeatureDim> factors_;
    std::vector<double> roots_;
};

struct FeatureObjective {
    const ShapeModel& model;
    FeatureNorm norm;
    double ridge;
};

/// Tries codes for one shape by its features. What the prior counts is a share of the mean square
/// of what moving one code changes at the start.
class FeatureTrials final : public CodeTrials {
  public:
    /// `truth` (V,9) and `start` (K) are finite, `moving` ascending and not empty. Borrows all.
    FeatureTrials(const FeatureObjective& objective, std::span<const float> truth,
                  std::span<const float> start, std::span<const int> moving);

  private:
    std::vector<float> rows(std::span<const float> codes) const override;
    void compare(Trial& trial) const override;
    NormalEquations error_equations(const Trial& trial) const override;

    const FeatureObjective& objective_;
    std::span<const float> truth_;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "code_trials.h"
#include "mscomp/base/metric_scale.h"
#include "mscomp/model/shape_model.h"

namespace mscomp {

struct FeatureObjective {
    const ShapeModel& model;
    MetricScale scale;  // differences of features count as their mean square where it brings them
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

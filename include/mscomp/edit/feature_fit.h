// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "mscomp/base/metric_scale.h"
#include "mscomp/model/shape_model.h"

namespace mscomp {

struct FeatureFitOptions {
    /// Features are compared as it scales them; of it only the factors count. By default as they
    /// are.
    MetricScale scale;
    int max_steps = 12;  // accepted ones; a linear decoder takes one
    /// Converged when a step lowers the objective by a smaller share of it.
    double least_gain = 1e-4;
    /// What it costs to move a code by 1, as a share of what that changes, squared, for a code of
    /// average effect at the start. So codes that do nothing, or the same, stay determined.
    double ridge = 1e-7;
};

struct FittedCodes {
    std::vector<float> codes;  // (K)
    double initial_rms = 0;    // root mean square of s (Dec(z) - X) at the start,
    double rms = 0;            // and now
    int steps = 0;
    bool converged = false;
};

/// Joint codes: those whose *features* match a shape best, over the components of all levels at
/// once (method §9, "Codes"): min over z of mean s² (Dec(z) - X)² + ridge |z - z⁰|², s the
/// factors of the scale with the roots of its metric, z⁰ the start. Gauss-Newton steps with the
/// derivatives of the decoder, damped where one does not help. The result is never farther from X
/// than the start, measured so.
class FeatureFit {
  public:
    /// Borrows the model. Throws UsageError if it decodes to positions.
    explicit FeatureFit(const ShapeModel& model, const FeatureFitOptions& options = {});
    FeatureFit(FeatureFit&&) noexcept;
    FeatureFit& operator=(FeatureFit&&) noexcept;
    ~FeatureFit();

    /// The fit of one shape, `truth` its features (V,9), from `start` (K), e.g. the codes of the
    /// encoder; only the codes `moving` move, empty meaning all. Safe to call from several threads,
    /// the same bits for any number of them. Throws MeshError for another V, UsageError for another
    /// K or a code that is not there, NumericalError if `truth`, `start` or what it decodes to is
    /// not finite.
    FittedCodes fit(std::span<const float> truth, std::span<const float> start,
                    std::span<const int> moving = {}) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mscomp

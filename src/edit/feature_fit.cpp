// SPDX-License-Identifier: MIT
#include "mscomp/edit/feature_fit.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "code_descent.h"
#include "feature_trials.h"
#include "listed.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "values.h"

namespace mscomp {

struct FeatureFit::State {
    FeatureObjective objective;
    FeatureFitOptions options;
};

FeatureFit::FeatureFit(const ShapeModel& model, const FeatureFitOptions& options) {
    if (model.rows() != ShapeRows::features) {
        throw UsageError("a model of positions, wanted one of features");
    }
    state_ = std::make_unique<State>(State{{model, options.scale, options.ridge}, options});
}
FeatureFit::FeatureFit(FeatureFit&&) noexcept = default;
FeatureFit& FeatureFit::operator=(FeatureFit&&) noexcept = default;
FeatureFit::~FeatureFit() = default;

FittedCodes FeatureFit::fit(std::span<const float> truth, std::span<const float> start,
                            std::span<const int> moving) const {
    const ShapeModel& model = state_->objective.model;
    const auto count = at(model.vertex_count());
    if (truth.size() != count * kFeatureDim) {
        throw MeshError(
            fmt::format("{} features to fit, wanted those of {} vertices", truth.size(), count));
    }
    if (static_cast<int>(start.size()) != model.code_count()) {
        throw UsageError(
            fmt::format("{} codes to start from, wanted {}", start.size(), model.code_count()));
    }
    for (std::size_t i = 0; i < truth.size(); ++i) {
        if (std::isfinite(truth[i])) continue;
        throw NumericalError(
            fmt::format("the features of the shape to fit are not finite at "
                        "vertex {}",
                        i / kFeatureDim));
    }
    if (!all_finite(start)) throw NumericalError("a code to start from is not finite");
    const std::vector<int> codes =
        listed({moving.begin(), moving.end()}, model.code_count(), "code");
    const FeatureTrials trials(state_->objective, truth, start, codes);
    Descent descent =
        descend(trials, {state_->options.max_steps, state_->options.least_gain, kUndampedRadius});
    return {std::move(descent.best.codes), std::sqrt(descent.initial_error),
            std::sqrt(descent.best.error), descent.steps, descent.converged};
}

}  // namespace mscomp

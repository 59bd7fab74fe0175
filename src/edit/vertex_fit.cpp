// SPDX-License-Identifier: MIT
#include "mscomp/edit/vertex_fit.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "code_descent.h"
#include "listed.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/points.h"
#include "values.h"
#include "vertex_trials.h"

namespace mscomp {
namespace {

constexpr double kFirstRadius = 1e3;

/// Makes the reference fit the unit ball; 1 for a reference without size.
double scale_of(const std::vector<Point>& reference) {
    const double scale = unit_ball_scale(reference);
    return scale > 0 ? scale : 1;
}

/// Inverse squares of the deviations, none of which counts as less than their root mean square:
/// what hardly moved in a few training shapes may be what another shape needs.
Eigen::VectorXd stiffnesses(const std::vector<float>& deviations, int count) {
    double least = 0;
    for (const float s : deviations) least += static_cast<double>(s) * static_cast<double>(s);
    least = least > 0 ? std::sqrt(least / static_cast<double>(deviations.size())) : 1;
    Eigen::VectorXd result = Eigen::VectorXd::Constant(count, 1 / (least * least));
    for (std::size_t k = 0; k < deviations.size(); ++k) {
        const double s = std::max(static_cast<double>(deviations[k]), least);
        result[static_cast<Eigen::Index>(k)] = 1 / (s * s);
    }
    return result;
}

}  // namespace

struct VertexFit::State {
    VertexObjective objective;

    const CodePositions& codes() const { return objective.codes; }
};

VertexFit::VertexFit(const ShapeModel& model, const TriangleMesh& reference, EdgeWeights weights,
                     const VertexFitOptions& options) {
    const int codes = model.code_count();
    if (model.vertex_count() != reference.vertex_count()) {
        throw UsageError(fmt::format("a model of {} vertices, wanted the {} of the reference",
                                     model.vertex_count(), reference.vertex_count()));
    }
    if (!options.code_deviations.empty() && options.code_deviations.size() != at(codes)) {
        throw UsageError(fmt::format("deviations of {} codes, wanted {}",
                                     options.code_deviations.size(), codes));
    }
    state_ = std::make_unique<State>(State{
        {CodePositions(model, reference, weights, options.solver), scale_of(reference.vertices),
         stiffnesses(options.code_deviations, codes), options}});
}
VertexFit::VertexFit(VertexFit&&) noexcept = default;
VertexFit& VertexFit::operator=(VertexFit&&) noexcept = default;
VertexFit::~VertexFit() = default;

FittedShape VertexFit::fit(std::span<const Point> truth, std::span<const float> start,
                           const FitSubset& subset) const {
    if (truth.size() != at(state_->codes().vertex_count())) {
        throw MeshError(fmt::format("a shape of {} vertices to fit, wanted {}", truth.size(),
                                    at(state_->codes().vertex_count())));
    }
    if (static_cast<int>(start.size()) != state_->codes().code_count()) {
        throw UsageError(fmt::format("{} codes to start from, wanted {}", start.size(),
                                     state_->codes().code_count()));
    }
    const FitSubset all{listed(subset.codes, state_->codes().code_count(), "code"),
                        listed(subset.vertices, state_->codes().vertex_count(), "vertex")};
    for (const int v : all.vertices) {
        if (vec(truth[at(v)]).allFinite()) continue;
        throw NumericalError(fmt::format("vertex {} of the shape to fit is not finite", v));
    }
    if (!all_finite(start)) throw NumericalError("a code to start from is not finite");
    const VertexTrials trials(state_->objective, truth, start, all);
    const VertexFitOptions& options = state_->objective.options;
    FittedShape result;
    Descent descent = descend(trials, {options.max_steps, options.least_gain, kFirstRadius});
    result.initial_rms = trials.rms(descent.initial_error);
    result.steps = descent.steps;
    result.converged = descent.converged;
    result.rms = trials.rms(descent.best.error);
    result.vertices = trials.placed(descent.best);
    result.codes = std::move(descent.best.codes);
    return result;
}

std::vector<FittedShape> VertexFit::fit(std::span<const std::vector<Point>> truths,
                                        std::span<const float> starts) const {
    const auto count = at(state_->codes().code_count());
    if (starts.size() != truths.size() * count) {
        throw UsageError(fmt::format("{} codes to start from, wanted {} x {}", starts.size(),
                                     truths.size(), count));
    }
    std::vector<FittedShape> result(truths.size());
    parallel_for(static_cast<std::int64_t>(truths.size()), [&](std::int64_t n) {
        const auto shape = at(n);
        result[shape] = fit(truths[shape], starts.subspan(shape * count, count));
    });
    return result;
}

std::vector<Point> VertexFit::positions(std::span<const float> codes,
                                        std::span<const Point> like) const {
    return state_->codes().positions(state_->codes().rows(codes), like);
}

std::vector<double> VertexFit::derivatives(std::span<const float> codes) const {
    return state_->codes().derivatives(codes, state_->codes().rows(codes),
                                       listed({}, state_->codes().code_count(), "code"));
}

}  // namespace mscomp

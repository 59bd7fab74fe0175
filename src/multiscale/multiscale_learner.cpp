// SPDX-License-Identifier: MIT
#include "multiscale/multiscale_learner.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "mscomp/base/error.h"
#include "mscomp/model/divergence.h"
#include "multiscale/ball_start.h"
#include "multiscale/given_balls.h"

namespace mscomp {
namespace {

constexpr double kAstray = 1.35;  // times the best loss (method §9)

}  // namespace

MultiscaleLearner::MultiscaleLearner(MultiscaleModel& model, const MultiscaleSettings& settings,
                                     const TrainConfig& config, const LearnerPlace& place,
                                     const ShapeSet& shapes, std::span<const int> train)
    : model_(model),
      settings_(settings),
      config_(config),
      place_(place),
      shapes_(shapes),
      train_(train.begin(), train.end()),
      mirror_(settings.mirror ? mirror_of(place.reference) : std::nullopt),
      squares_(one_rings_of_faces(place.reference.vertex_count(), place.reference.faces),
               model.scale(), settings.damping) {}

/// What the configuration says, or with few shapes what these say of it.
Choices MultiscaleLearner::chosen() {
    const Choices all{settings_.global_components, config_.fill_up_to};
    const bool is_few = std::ssize(train_) < kFewShapes;
    if (!settings_.select) return all;
    std::vector<Choices> candidates{{all.global_components, 0}};
    if (is_few) {
        for (const Choices& more : {Choices{0, 0}, all, Choices{0, all.fill_up_to}}) {
            if (std::ranges::find(candidates, more) == candidates.end()) candidates.push_back(more);
        }
    }
    constexpr std::ptrdiff_t kFewest = 3;
    if (candidates.size() == 1) return candidates.front();
    if (std::ssize(train_) < kFewest) return candidates.back();
    ChosenBySpaceError best = choose(candidates, settings_, config_.seed,
                                     {place_.reference, place_.weights, place_.distances,
                                      model_.scale(), mirror_ ? &*mirror_ : nullptr},
                                     shapes_, train_);
    notes_ = std::move(best.notes);
    return best.choices;
}

TrainingPool& MultiscaleLearner::pool() {
    if (!pool_) {
        pool_.emplace(shapes_, train_, mirror_ ? &*mirror_ : nullptr, place_.distances,
                      model_.scale(),
                      TrainingPool::Options{model_.fill_up_to, config_.seed, settings_.between});
    }
    return *pool_;
}

void MultiscaleLearner::start() {
    notes_.clear();
    const Choices choices = chosen();
    MultiscaleSettings settings = settings_;
    settings.global_components = choices.global_components;
    model_.fill_up_to = choices.fill_up_to;
    pool_.reset();
    begin(start_balls(pool().rows(0), settings, place_.distances), {});
}

/// Nothing is chosen: components and keys are as they are given.
void MultiscaleLearner::start_from(const GivenComponents& given) {
    require_levels(given, settings_);
    notes_.clear();
    BallComponents components = given_balls(given, model_.map());
    model_.fill_up_to = config_.fill_up_to;
    pool_.reset();
    begin(std::move(components), given.parents);
}

void MultiscaleLearner::begin(BallComponents components, std::vector<int> parents) {
    descent_.reset();
    model_.set_components(std::move(components));
    model_.set_parents(std::move(parents));
    model_.space_state.reset();
    state_ = {};
}

EpochReport MultiscaleLearner::run_epoch() {
    const auto begin = std::chrono::steady_clock::now();
    EpochReport report = state_.epoch < settings_.rounds ? alternate() : descend();
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - begin;
    if (!std::isfinite(report.total)) {
        throw DivergenceError(fmt::format("epoch {}: the error is not finite", state_.epoch + 1));
    }
    ++state_.epoch;
    state_.total = report.total;
    if (state_.first_error == 0) state_.first_error = report.total;
    report.step_ms = spent.count() / static_cast<double>(report.state.step - state_.step);
    state_.step = report.state.step;
    report.state = state_;
    return report;
}

EpochReport MultiscaleLearner::alternate() {
    BallComponents components = model_.components();
    const double error = squares_.round(pool().rows(state_.epoch), components);
    if (std::isfinite(error)) model_.set_components(std::move(components));
    EpochReport report{state_, error, {error, 0}, 0, 0, 1};
    ++report.state.step;
    return report;
}

/// TrainingState::window_mean is the lowest mean loss of an epoch in space so far.
EpochReport MultiscaleLearner::descend() {
    const MetricRows& rows = pool().rows(settings_.rounds);
    if (!descent_) {
        descent_ = std::make_unique<SpaceDescent>(place_.reference, place_.weights, model_.scale(),
                                                  rows, settings_.feature_share);
    }
    if (model_.space_state && model_.space_state->codes.cols() != rows.shape_count()) {
        throw UsageError(fmt::format("codes in space of {} shapes, wanted those of {}",
                                     model_.space_state->codes.cols(), rows.shape_count()));
    }
    BallComponents components = model_.components();
    SpaceState state = model_.space_state ? *model_.space_state : descent_->begin(components);
    double best = model_.space_state ? state_.window_mean : 0;
    const SpaceDescent::Report done = descend_from(components, state);
    if (best == 0) best = done.first;
    if (!std::isfinite(done.total) || done.total > kAstray * best) {
        throw DivergenceError(fmt::format("epoch {}: the loss is {:.4g}, after {:.4g}",
                                          state_.epoch + 1, done.total, best));
    }
    state_.window_mean = std::min(best, done.total);
    model_.set_components(std::move(components));
    model_.space_state = std::move(state);
    EpochReport report{state_, done.total, {done.features, done.space}, state_.rate_factor, 0, 1};
    report.state.step += SpaceDescent::kSteps;
    return report;
}

/// Features that are not finite are no error of the shapes here.
SpaceDescent::Report MultiscaleLearner::descend_from(BallComponents& components,
                                                     SpaceState& state) const {
    try {
        return descent_->run_epoch(state_.rate_factor, components, state);
    } catch (const NumericalError& error) {
        throw DivergenceError(fmt::format("epoch {}: {}", state_.epoch + 1, error.what()));
    }
}

CodeTable MultiscaleLearner::codes() { return model_.encode(shapes_, train_); }

}  // namespace mscomp

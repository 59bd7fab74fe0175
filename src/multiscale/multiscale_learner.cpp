// SPDX-License-Identifier: MIT
#include "multiscale/multiscale_learner.h"

#include <chrono>
#include <cmath>
#include <numeric>
#include <utility>

#include "mscomp/base/error.h"
#include "multiscale/alternating_squares.h"
#include "multiscale/ball_start.h"

namespace mscomp {
namespace {

std::vector<int> as_they_are(int vertices) {
    std::vector<int> same(at(vertices));
    std::iota(same.begin(), same.end(), 0);
    return same;
}

}  // namespace

MultiscaleLearner::MultiscaleLearner(MultiscaleModel& model, const MultiscaleSettings& settings,
                                     const TrainConfig& config, DistanceRows& distances,
                                     const ShapeSet& shapes, std::span<const int> train)
    : model_(model),
      settings_(settings),
      config_(config),
      distances_(distances),
      shapes_(shapes),
      train_(train.begin(), train.end()) {
    if (getenv("MIRROR")) mirror_ = mirror_of(model.reference_);
    const ShapeFeatures* from = &shapes;
    std::vector<int> all = train_;
    if (mirror_) {
        mirrored_.emplace(shapes, *mirror_);
        from = &*mirrored_;
        for (const int m : train_) all.push_back(shapes.shape_count() + m);
    }
    mixed_.emplace(*from, all, distances, as_they_are(shapes.vertex_count()), config.seed,
             getenv("BETW") ? atof(getenv("BETW")) : 0);
}

/// The training shapes, and mixed ones up to TrainConfig::fill_up_to, some of them new each time.
void MultiscaleLearner::gather(std::int64_t epoch) {
    constexpr std::int64_t kReplaced = 4;
    std::vector<int> wanted = train_;
    if (mirror_ && getenv("WHOLE")) for (const int m : train_) wanted.push_back(shapes_.shape_count() + m);
    const std::int64_t count = std::max<std::int64_t>(0, config_.fill_up_to - std::ssize(wanted));
    for (std::int64_t i = 0; i < count; ++i) {
        // Mix m is replaced by mix m + count.
        const std::int64_t done = epoch * kReplaced;
        const std::int64_t m = i + (done > i ? (done - i + count - 1) / count * count : 0);
        wanted.push_back(mixed_->shape_count() + static_cast<int>(m));
    }
    const int size = static_cast<int>(wanted.size());
    if (!rows_ || rows_->shape_count() != size) {
        rows_ = std::make_unique<MetricRows>(shapes_.vertex_count(), size);
        gathered_.assign(wanted.size(), -1);
    }
    std::vector<float> row(at(shapes_.vertex_count()) * 9);
    for (int m = 0; m < size; ++m) {
        if (gathered_[at(m)] == wanted[at(m)]) continue;
        model_.scale().map(mixed_->shape(wanted[at(m)]), row);
        mixed_->forget(wanted[at(m)]);
        rows_->set(m, row);
        gathered_[at(m)] = wanted[at(m)];
    }
}

void MultiscaleLearner::start() {
    if (getenv("STARTPOOL")) gather(0); else { int keep = 0; std::swap(const_cast<TrainConfig&>(config_).fill_up_to, keep); gather(0); std::swap(const_cast<TrainConfig&>(config_).fill_up_to, keep); }
    model_.set_components(start_balls(*rows_, settings_, distances_));
    state_ = {};
}

bool MultiscaleLearner::is_over() const { return state_.epoch >= config_.epochs; }

EpochReport MultiscaleLearner::run_epoch() {
    const auto begin = std::chrono::steady_clock::now();
    gather(state_.epoch);
    BallComponents components = model_.components();
    const double error = alternate(*rows_, settings_.damping, components, model_.rings_, model_.scale().roots());
    if (!std::isfinite(error)) {
        throw NumericalError("alternating least squares of features that are not finite");
    }
    model_.set_components(std::move(components));
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - begin;
    ++state_.epoch;
    ++state_.step;
    state_.total = error;
    if (state_.first_error == 0) state_.first_error = error;
    return {state_, error, {error}, 0, spent.count(), 1};
}

CodeTable MultiscaleLearner::codes() { return model_.encode(shapes_, train_); }

}  // namespace mscomp

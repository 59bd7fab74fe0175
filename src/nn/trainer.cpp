// SPDX-License-Identifier: MIT
#include "mscomp/nn/trainer.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/random.h"
#include "mscomp/nn/optimizer.h"

namespace mscomp::nn {

namespace {

/// The batch of `order` that begins at `first`.
std::span<const int> batch_of(const std::vector<int>& order, std::size_t first, std::size_t size) {
    return std::span(order).subspan(first, std::min(size, order.size() - first));
}

}  // namespace

Trainer::Trainer(Model<float>& model, const Config& config, const ScaledFeatures& features,
                 std::span<const int> shapes)
    : model_(model),
      config_(config),
      features_(features),
      shapes_(shapes.begin(), shapes.end()),
      loader_(features_, model.order(), lane_count(model.batch_capacity())) {}

Trainer::Trainer(Model<float>& model, const Config& config, std::span<const float> features,
                 std::span<const int> shapes)
    : model_(model),
      config_(config),
      memory_(std::make_unique<MemoryFeatures>(features, model.vertex_count())),
      features_{*memory_},
      shapes_(shapes.begin(), shapes.end()),
      loader_(features_, model.order(), lane_count(model.batch_capacity())) {}

void Trainer::start() {
    model_.start(config_.train, features_, shapes_);
    loaded_.clear();
    state_ = {};
}

std::vector<int> Trainer::order_of_epoch(std::int64_t epoch) const {
    std::vector<int> order = shapes_;
    const CounterRandom random(config_.train.seed, static_cast<std::uint64_t>(epoch) + 1000);
    const std::vector<int> drawn = random.permutation(static_cast<int>(shapes_.size()));
    for (std::size_t i = 0; i < order.size(); ++i) {
        order[i] = shapes_[static_cast<std::size_t>(drawn[i])];
    }
    return order;
}

EpochReport Trainer::run_epoch() {
    EpochReport report;
    report.terms.resize(model_.term_names().size());
    const auto batch = static_cast<std::size_t>(model_.batch_capacity());
    const bool is_full_batch = shapes_.size() <= batch;
    const std::vector<int> order = is_full_batch ? shapes_ : order_of_epoch(state_.epoch);
    int steps = 0;
    const auto begin = std::chrono::steady_clock::now();
    for (std::size_t first = 0; first < order.size(); first += batch, ++steps) {
        load(batch_of(order, first, batch));
        if (first + batch < order.size()) {
            loader_.prepare(batch_of(order, first + batch, batch));
        } else if (!is_full_batch) {
            loader_.prepare(batch_of(order_of_epoch(state_.epoch + 1), 0, batch));
        }
        step(report);
    }
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - begin;
    report.step_ms = spent.count() / steps;
    report.total /= steps;
    for (double& term : report.terms) term /= steps;
    report.touched = model_.touched();
    ++state_.epoch;
    report.state = state_;
    return report;
}

void Trainer::load(std::span<const int> batch) {
    if (std::ranges::equal(batch, loaded_)) return;
    loaded_.clear();
    if (const LaneBatch* prepared = loader_.take(batch)) {
        model_.load_batch(*prepared);
    } else {
        model_.load_batch(features_, batch);
    }
    loaded_.assign(batch.begin(), batch.end());
}

void Trainer::step(EpochReport& report) {
    model_.parameters().zero_grad();
    model_.prepare_step(config_.train.seed, state_.step + 1);
    const float loss = model_.forward_and_backward();
    require_finite(loss);

    ++state_.step;
    state_.total = loss;
    report.learning_rate = learning_rate_at(config_.train, state_.step);
    report.total += loss;
    const std::vector<double> terms = model_.term_values();
    for (std::size_t i = 0; i < terms.size(); ++i) report.terms[i] += terms[i];
    model_.update(config_.train, report.learning_rate, state_.step);
}

void Trainer::require_finite(float loss) {
    if (!std::isfinite(loss)) {
        const auto* op = model_.tape().first_non_finite();
        throw NumericalError(op ? op->name() : "weighted_sum", state_.step + 1, "the result");
    }
    const int broken = first_non_finite_grad(model_.parameters());
    if (broken >= 0) {
        throw NumericalError("backward", state_.step + 1,
                             "the gradient of " + model_.parameters().entry(broken).name);
    }
}

std::vector<std::vector<float>> Trainer::codes() {
    std::vector<std::vector<float>> all(model_.level_sizes().size());
    const auto batch = static_cast<std::size_t>(model_.batch_capacity());
    for (std::size_t first = 0; first < shapes_.size(); first += batch) {
        load(batch_of(shapes_, first, batch));
        if (first + batch < shapes_.size()) {
            loader_.prepare(batch_of(shapes_, first + batch, batch));
        }
        model_.forward();
        for (std::size_t l = 0; l < all.size(); ++l) {
            const std::vector<float> codes = model_.codes(static_cast<int>(l));
            all[l].insert(all[l].end(), codes.begin(), codes.end());
        }
    }
    return all;
}

}  // namespace mscomp::nn

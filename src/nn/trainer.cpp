// SPDX-License-Identifier: MIT
#include "nn/trainer.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "mscomp/base/index.h"
#include "mscomp/base/random.h"
#include "mscomp/model/divergence.h"
#include "nn/optimizer.h"

namespace mscomp::nn {

namespace {

bool is_reconstruction(const std::string& term) { return term.ends_with("reconstruction"); }

/// The error of all autoencoders: what training is for. Other terms have minima of their own.
double reconstruction_of(const std::vector<double>& terms, const std::vector<std::string>& names) {
    double sum = 0;
    for (std::size_t i = 0; i < terms.size(); ++i) {
        if (is_reconstruction(names[i])) sum += terms[i];
    }
    return sum;
}

/// The batch of `order` that begins at `first`.
std::span<const int> batch_of(const std::vector<int>& order, std::size_t first, std::size_t size) {
    return std::span(order).subspan(first, std::min(size, order.size() - first));
}

}  // namespace

int epoch_size(const TrainConfig& config, int shapes, int vertices) {
    constexpr int kLargeMesh = 200000;
    if (shapes >= config.fill_below) return shapes;
    const int wanted =
        vertices > kLargeMesh ? std::min(config.fill_up_to, lane_count(shapes)) : config.fill_up_to;
    return std::max(shapes, wanted);
}

Trainer::Trainer(Model<float>& model, const TrainConfig& config, const ScaledFeatures& features,
                 std::span<const int> shapes)
    : model_(model),
      config_(config),
      mixed_(epoch_size(config, static_cast<int>(shapes.size()), model.vertex_count()) >
                     static_cast<int>(shapes.size())
                 ? std::make_unique<MixedFeatures>(features.shapes, shapes, model.inner_distances(),
                                                   model.order().to_user, config.seed)
                 : nullptr),
      features_{mixed_ ? *mixed_ : features.shapes, features.scale},
      shapes_(shapes.begin(), shapes.end()),
      loader_(features_, model.order(), lane_count(model.batch_capacity())) {}

Trainer::Trainer(Model<float>& model, const TrainConfig& config, std::span<const float> features,
                 std::span<const int> shapes)
    : Trainer(model, config, std::make_unique<MemoryFeatures>(features, model.vertex_count()),
              shapes) {}

Trainer::Trainer(Model<float>& model, const TrainConfig& config,
                 std::unique_ptr<MemoryFeatures> memory, std::span<const int> shapes)
    : Trainer(model, config, ScaledFeatures{*memory}, shapes) {
    memory_ = std::move(memory);
}

void Trainer::start() {
    model_.start(config_, features_, shapes_of_epoch(0));
    loaded_.clear();
    state_ = {};
}

bool Trainer::is_over() const {
    const TrainConfig& train = config_;
    return state_.epoch >= train.epochs || (state_.is_plateau && train.plateau_epochs > 0);
}

std::vector<int> Trainer::shapes_of_epoch(std::int64_t epoch) const {
    constexpr std::int64_t kKeptEpochs = 8;
    std::vector<int> all = shapes_;
    const int count = static_cast<int>(shapes_.size());
    const int mixed = epoch_size(config_, count, model_.vertex_count()) - count;
    for (std::int64_t m = 0; m < mixed; ++m) {
        all.push_back(features_.shapes.shape_count() +
                      static_cast<int>((epoch / kKeptEpochs) * mixed + m));
    }
    return all;
}

/// All shapes as they are where one batch holds them, else drawn anew for every epoch.
std::vector<int> Trainer::order_of_epoch(std::int64_t epoch) const {
    std::vector<int> all = shapes_of_epoch(epoch);
    if (static_cast<int>(all.size()) <= model_.batch_capacity()) return all;
    std::vector<int> order;
    const CounterRandom random(config_.seed, static_cast<std::uint64_t>(epoch) + 1000);
    for (const int drawn : random.permutation(static_cast<int>(all.size()))) {
        order.push_back(all[at(drawn)]);
    }
    return order;
}

EpochReport Trainer::run_epoch() {
    EpochReport report;
    report.terms.resize(model_.term_names().size());
    const auto batch = at(model_.batch_capacity());
    const std::vector<int> order = order_of_epoch(state_.epoch);
    int steps = 0;
    double energy = 0;
    const auto begin = std::chrono::steady_clock::now();
    for (std::size_t first = 0; first < order.size(); first += batch, ++steps) {
        load(batch_of(order, first, batch));
        const bool is_last = first + batch >= order.size();
        const std::vector<int> later =
            is_last ? order_of_epoch(state_.epoch + 1) : std::vector<int>();
        const auto next =
            is_last ? batch_of(later, 0, batch) : batch_of(order, first + batch, batch);
        if (!std::ranges::equal(next, loaded_)) loader_.prepare(next);
        step(report);
        energy += energy_;
    }
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - begin;
    report.step_ms = spent.count() / steps;
    report.total /= steps;
    for (double& term : report.terms) term /= steps;
    report.touched = model_.touched();
    const double error = reconstruction_of(report.terms, model_.term_names());
    require_not_astray(error, energy / steps);
    ++state_.epoch;
    watch_plateau(error);
    report.state = state_;
    return report;
}

/// Epochs of a window are counted, since a resumed run may have windows of another length.
void Trainer::watch_plateau(double error) {
    const TrainConfig& train = config_;
    const double before = state_.window_mean;
    state_.is_plateau = false;
    if (train.plateau_epochs == 0) {
        state_.window_mean = state_.window_sum = 0;
        state_.window_epochs = 0;
        return;
    }
    state_.window_sum += error;
    if (++state_.window_epochs < train.plateau_epochs) return;
    state_.window_mean = state_.window_sum / static_cast<double>(state_.window_epochs);
    state_.is_plateau = before > 0 && state_.window_mean > (1 - train.plateau_gain) * before;
    state_.window_sum = 0;
    state_.window_epochs = 0;
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
    energy_ = model_.input_energy();
}

void Trainer::step(EpochReport& report) {
    model_.parameters().zero_grad();
    model_.prepare_step(config_.seed, state_.step + 1);
    const float loss = model_.forward_and_backward();
    require_finite_loss(loss);
    require_finite_gradients();

    ++state_.step;
    state_.total = loss;
    report.learning_rate = state_.rate_factor * learning_rate_at(config_, state_.step);
    report.total += loss;
    const std::vector<double> terms = model_.term_values();
    for (std::size_t i = 0; i < terms.size(); ++i) report.terms[i] += terms[i];
    if (state_.first_error == 0) {
        state_.first_error = reconstruction_of(terms, model_.term_names());
    }
    model_.update(config_, report.learning_rate, state_.step);
}

void Trainer::require_finite_loss(float loss) {
    if (std::isfinite(loss)) return;
    const auto* op = model_.tape().first_non_finite();
    throw DivergenceError(op ? op->name() : "weighted_sum", state_.step + 1, "the result");
}

void Trainer::require_finite_gradients() {
    ParameterSet<float>& parameters = model_.parameters();
    const int broken = first_non_finite<float>(parameters, parameters.all_grads());
    if (broken < 0) return;
    throw DivergenceError("backward", state_.step + 1,
                          "the gradient of " + parameters.entry(broken).name);
}

void Trainer::fail_after_update(const std::string& what) const {
    throw DivergenceError(
        fmt::format("step {}: after its update {} is not finite", state_.step, what));
}

void Trainer::require_finite_parameters() {
    ParameterSet<float>& parameters = model_.parameters();
    const auto require = [&](std::span<const float> all, const char* what) {
        const int broken = first_non_finite(parameters, all);
        if (broken < 0) return;
        fail_after_update(what + parameters.entry(broken).name);
    };
    require(parameters.all_values(), "");
    require(parameters.all_moments1(), "the first moment of ");
    require(parameters.all_moments2(), "the second moment of ");
}

void Trainer::require_not_astray(double error, double energy) const {
    const std::vector<std::string> names = model_.term_names();
    const auto levels = std::ranges::count_if(names, is_reconstruction);
    const double most =
        kAstray * std::max(static_cast<double>(levels) * energy, state_.first_error);
    // Before the first step, or if all shapes are the reference, there is nothing to compare with.
    if (state_.first_error == 0 || energy == 0 || error <= most) return;
    throw DivergenceError(
        fmt::format("step {}: the reconstruction error is {:.4g}, that of no model at all {:.4g}",
                    state_.step, error, energy));
}

CodeTable Trainer::codes() {
    require_finite_parameters();
    CodeTable table;
    for (const LevelSize& level : model_.level_sizes()) table.code_count += level.codes();
    const auto batch = at(model_.batch_capacity());
    double error = 0, energy = 0;
    int passes = 0;
    for (std::size_t first = 0; first < shapes_.size(); first += batch, ++passes) {
        load(batch_of(shapes_, first, batch));
        if (first + batch < shapes_.size()) {
            loader_.prepare(batch_of(shapes_, first + batch, batch));
        }
        if (!std::isfinite(model_.forward())) fail_after_update("the loss");
        error += reconstruction_of(model_.term_values(), model_.term_names());
        energy += energy_;
        const std::vector<float> codes = model_.all_codes();
        table.values.insert(table.values.end(), codes.begin(), codes.end());
    }
    require_not_astray(error / passes, energy / passes);
    return table;
}

}  // namespace mscomp::nn

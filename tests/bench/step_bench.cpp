// SPDX-License-Identifier: MIT
// One training step of the stacked model: zero gradients, forward, backward, Adam, proximal step;
// in milliseconds, with the peak memory of the whole case.
//
//   step_bench                                         2,000 to 50,000 vertices
//   step_bench --large                                 also 200,000 and 1,000,000
//   step_bench --benchmark_filter='vertices:12500/shapes:36/threads:2'
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <string_view>
#include <vector>

#include "banded_sphere.h"
#include "mscomp/base/parallel.h"
#include "nn/optimizer.h"
#include "nn/stacked_model.h"
#include "nn/start.h"
#include "peak_memory.h"
#include "run_benchmarks.h"

namespace mscomp::nn {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

/// What is timed, one name per choice.
struct Case {
    std::string_view model;  // default; pytorch: all that the PyTorch step computes, see docs
    std::string_view start;  // deflation: what users get; random: no zeros anywhere
    int vertices, shapes, threads;
};

/// The model of the PyTorch step: tanh of codes and of decoded features, decoders with matrices of
/// their own, masks as in the paper, sparsity by its subgradient.
StackedConfig model_of(const Case& what) {
    StackedConfig config;
    if (what.model == "default") return config;
    config.latent_activation = config.decoder_fc_activation = Activation::tanh;
    config.tied = Tied::none;
    config.mask_power = 1;
    for (LevelConfig& level : config.levels) level.max_support = 1;
    return config;
}

/// Random features (N,V,9) within +-0.95; shape 0 is the reference, which is zero.
std::vector<float> random_features(const Case& what) {
    const CounterRandom random(1, 1);
    const std::size_t row = static_cast<std::size_t>(what.vertices) * 9;
    std::vector<float> features(row * static_cast<std::size_t>(what.shapes));
    for (std::size_t i = row; i < features.size(); ++i) {
        features[i] = static_cast<float>(1.9 * random.uniform(i) - 0.95);
    }
    return features;
}

/// Times of the parts of every step, in milliseconds.
struct StepTimes {
    std::vector<double> whole, passes, update;
};

/// One step; false where the loss is not finite.
bool step(StackedModel<float>& model, bool proximal, std::int64_t number, StepTimes& times) {
    const auto begin = Clock::now();
    model.parameters().zero_grad();
    const float loss = model.forward_and_backward();
    if (model.has_supports() && number == 1) model.adapt_supports(1000, number);
    const auto passes = Clock::now();
    adam_step(model.parameters(), 1e-3, number);
    if (proximal) proximal_step(model, 1000, 1e-3, number);
    const auto end = Clock::now();
    times.passes.push_back(milliseconds(begin, passes));
    times.update.push_back(milliseconds(passes, end));
    times.whole.push_back(milliseconds(begin, end));
    return std::isfinite(loss);
}

/// Milliseconds that deciding the supports anew adds to a step, as training does now and then.
double time_of_adapting(StackedModel<float>& model, std::int64_t number) {
    model.parameters().zero_grad();
    model.forward();
    model.backward();
    const auto begin = Clock::now();
    model.adapt_supports(1000, number);
    return milliseconds(begin, Clock::now());
}

void stacked_step(benchmark::State& state, const Case& what) {
    constexpr std::int64_t kWarmUp = 2;
    forget_peak_memory();
    set_thread_count(what.threads);
    TriangleMesh mesh = banded_sphere(what.vertices);
    if (mesh.face_count() != 2 * what.vertices - 4) {
        state.SkipWithError("the sphere is not closed");
        return;
    }
    SphereRows distances(mesh.vertices);
    StackedModel<float>::Options options;
    options.batch = what.shapes;
    options.sparsity_gradient = what.model == "pytorch";
    options.supports = what.model == "default";
    StackedModel<float> model(model_of(what), {}, one_rings_of_faces(what.vertices, mesh.faces),
                              distances, options);
    const std::vector<float> features = random_features(what);
    std::vector<int> which(static_cast<std::size_t>(what.shapes));
    std::iota(which.begin(), which.end(), 0);
    const auto start_begin = Clock::now();
    if (what.start == "random") {
        start_random(model, 1);
    } else {
        start_deflation(model, features, which);
    }
    state.counters["start_ms"] = milliseconds(start_begin, Clock::now());
    model.load_batch(std::span<const float>(features), std::span<const int>(which));
    StepTimes times;
    std::int64_t number = 0;
    bool finite = true;
    while (number < kWarmUp && finite) {
        finite = step(model, !options.sparsity_gradient, ++number, times);
    }
    times = {};
    for (auto _ : state) {
        finite = finite && step(model, !options.sparsity_gradient, ++number, times);
        if (!finite) {
            state.SkipWithError("the loss is not finite");
            break;
        }
        state.SetIterationTime(times.whole.back() / 1000);
    }
    set_thread_count(0);
    if (!finite) return;
    state.counters["touched"] = model.touched(1);
    state.counters["median_ms"] = median(times.whole);
    state.counters["min_ms"] = *std::min_element(times.whole.begin(), times.whole.end());
    state.counters["passes_ms"] = median(times.passes);
    state.counters["update_ms"] = median(times.update);
    state.counters["peak_mib"] = peak_memory_mib();
    state.counters["touched"] = model.touched(1);
    if (model.has_supports()) state.counters["adapt_ms"] = time_of_adapting(model, number + 1);
}

void add(const Case& what) {
    const std::string name =
        fmt::format("stacked_step/model:{}/start:{}/vertices:{}/shapes:{}/threads:{}", what.model,
                    what.start, what.vertices, what.shapes, what.threads);
    const double size = static_cast<double>(what.vertices) * what.shapes;
    benchmark::RegisterBenchmark(name.c_str(),
                                 [what](benchmark::State& state) { stacked_step(state, what); })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond)
        ->Iterations(size < 1e6   ? 15
                     : size < 4e6 ? 7
                                  : 3);
}

void add_all(bool large) {
    for (const auto& [model, start] :
         {std::pair{"default", "deflation"}, {"default", "random"}, {"pytorch", "random"}}) {
        for (const int vertices : {2000, 5023, 12500, 50000, 200000, 1000000}) {
            if (vertices > 50000 && !large) continue;
            for (const int shapes : {20, 36, 72, 144, 256}) {
                for (const int threads : {1, 2}) {
                    add({model, start, vertices, shapes, threads});
                }
            }
        }
    }
}

}  // namespace
}  // namespace mscomp::nn

int main(int argc, char** argv) { return mscomp::run_benchmarks(argc, argv, mscomp::nn::add_all); }

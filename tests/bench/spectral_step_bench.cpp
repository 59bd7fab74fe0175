// SPDX-License-Identifier: MIT
// One training step of the spectral VAE: zero gradients, forward, backward, Adam, proximal step; in
// milliseconds, with the times of its parts and the peak memory of the whole case.
//
//   spectral_step_bench                                2,000 to 50,000 vertices
//   spectral_step_bench --large                        also 200,000 and 1,000,000
//   spectral_step_bench --benchmark_filter='vertices:12500/shapes:36/threads:2'
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "banded_sphere.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "nn/optimizer.h"
#include "nn/spectral_vae.h"
#include "peak_memory.h"
#include "run_benchmarks.h"

namespace mscomp::nn {
namespace {

using Clock = std::chrono::steady_clock;

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

/// What is timed, one name per choice.
struct Case {
    std::string_view model;  // default; small_ops; pytorch: all that the PyTorch step computes
    int vertices, shapes, threads;
};

/// The literal VAE, as the PyTorch step computes it.
SpectralConfig config_of(const Case& what) {
    SpectralConfig config;
    if (what.model != "pytorch") return config;
    config.tied = Tied::none;
    config.spread = Spread::linear;
    config.straight_through = StraightThrough::identity;
    config.range_term = RangeTerm::l2;
    return config;
}

/// Random parameters, no zeros anywhere; every component has a clear centre, so that distances are
/// looked up in a table, as those of PyTorch are, and not computed anew in every step.
void start_random(SpectralVae<float>& model) {
    ParameterSet<float>& parameters = model.parameters();
    for (int index = 0; index < parameters.count(); ++index) {
        if (index == model.indices().ranges) continue;
        const bool is_filter = parameters.entry(index).extents.size() == 3;
        const double scale = is_filter ? 1.0 / 3 : 1 / std::sqrt(9.0 * model.vertex_count());
        const CounterRandom random(2, static_cast<std::uint64_t>(index));
        const std::span<float> value = parameters.value(index);
        for (std::size_t i = 0; i < value.size(); ++i) {
            value[i] = static_cast<float>(scale * random.normal(i));
        }
    }
    const std::span<float> weights = parameters.value(model.indices().weights);
    const int components = model.config().components, vertices = model.vertex_count();
    for (int k = 0; k < components; ++k) {
        const int center = static_cast<int>(static_cast<std::int64_t>(vertices) * k / components);
        weights[(static_cast<std::size_t>(k) * static_cast<std::size_t>(vertices) +
                 static_cast<std::size_t>(center)) *
                9] = 1.0F;
    }
}

/// Random features (N,V,9) within +-0.95.
std::vector<float> random_features(const Case& what) {
    const CounterRandom random(1, 1);
    std::vector<float> features(static_cast<std::size_t>(what.vertices) * 9 *
                                static_cast<std::size_t>(what.shapes));
    for (std::size_t i = 0; i < features.size(); ++i) {
        features[i] = static_cast<float>(1.9 * random.uniform(i) - 0.95);
    }
    return features;
}

/// Times of the parts of every step by name, in milliseconds.
using Times = std::map<std::string, std::vector<double>>;

class Stopwatch {
  public:
    explicit Stopwatch(Times& times) : times_(times), begin_(Clock::now()), last_(begin_) {}
    void lap(const std::string& name) { add(name, last_); }
    void end(const std::string& name) { add(name, begin_); }

  private:
    void add(const std::string& name, Clock::time_point from) {
        last_ = Clock::now();
        times_[name].push_back(std::chrono::duration<double, std::milli>(last_ - from).count());
    }
    Times& times_;
    Clock::time_point begin_, last_;
};

/// One step; false where the loss is not finite.
bool step(SpectralVae<float>& model, bool proximal, std::int64_t number, Times& times) {
    Stopwatch watch(times);
    model.parameters().zero_grad();
    watch.lap("zero_ms");
    model.draw_noise(1, number);
    const float loss = model.forward();
    watch.lap("forward_ms");
    model.backward();
    watch.lap("backward_ms");
    adam_step(model.parameters(), 1e-3, number);
    watch.lap("adam_ms");
    if (proximal) proximal_step(model, 1000, 1e-3, number);
    model.clamp_ranges();
    watch.lap("proximal_ms");
    watch.end("median_ms");
    return std::isfinite(loss);
}

void spectral_step(benchmark::State& state, const Case& what) {
    constexpr std::int64_t kWarmUp = 2;
    forget_peak_memory();
    set_thread_count(what.threads);
    TriangleMesh mesh = banded_sphere(what.vertices);
    SphereRows distances(mesh.vertices);
    SpectralVae<float>::Options options;
    options.batch = what.shapes;
    options.sparsity_gradient = what.model == "pytorch";
    options.fused = what.model != "small_ops";
    SpectralVae<float> model(config_of(what), {}, one_rings_of_faces(what.vertices, mesh.faces), {},
                             distances, options);
    start_random(model);
    const std::vector<float> features = random_features(what);
    std::vector<int> which(static_cast<std::size_t>(what.shapes));
    std::iota(which.begin(), which.end(), 0);
    model.load_batch(std::span<const float>(features), std::span<const int>(which));
    Times times;
    std::int64_t number = 0;
    bool finite = true;
    while (number < kWarmUp && finite) {
        finite = step(model, !options.sparsity_gradient, ++number, times);
    }
    times.clear();
    for (auto _ : state) {
        finite = finite && step(model, !options.sparsity_gradient, ++number, times);
        if (!finite) {
            state.SkipWithError("the loss is not finite");
            break;
        }
        state.SetIterationTime(times["median_ms"].back() / 1000);
    }
    set_thread_count(0);
    if (!finite) return;
    const std::vector<double>& whole = times["median_ms"];
    state.counters["min_ms"] = *std::min_element(whole.begin(), whole.end());
    for (const auto& [name, values] : times) state.counters[name] = median(values);
    state.counters["update_ms"] = median(times["adam_ms"]) + median(times["proximal_ms"]);
    state.counters["peak_mib"] = peak_memory_mib();
}

void add(const Case& what) {
    // The names of the default end in vertices/shapes/threads, as those of the stacked model do.
    const std::string size_name = fmt::format("vertices:{}/shapes:{}", what.vertices, what.shapes);
    const std::string name =
        what.model == "default"
            ? fmt::format("spectral_step/model:default/{}/threads:{}", size_name, what.threads)
            : fmt::format("spectral_step/{}/model:{}/threads:{}", size_name, what.model,
                          what.threads);
    const double size = static_cast<double>(what.vertices) * what.shapes;
    benchmark::RegisterBenchmark(name.c_str(),
                                 [what](benchmark::State& state) { spectral_step(state, what); })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond)
        ->Iterations(size < 1e6 ? 15 : 5);
}

void add_all(bool large) {
    for (const std::string_view model : {"default", "pytorch", "small_ops"}) {
        for (const int vertices : {2000, 5023, 12500, 50000, 200000, 1000000}) {
            if (vertices > 50000 && !large) continue;
            for (const int shapes : {20, 36, 256}) {
                for (const int threads : {1, 2}) add({model, vertices, shapes, threads});
            }
        }
    }
}

}  // namespace
}  // namespace mscomp::nn

int main(int argc, char** argv) { return mscomp::run_benchmarks(argc, argv, mscomp::nn::add_all); }

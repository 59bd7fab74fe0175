// SPDX-License-Identifier: MIT
// The kind multiscale on spheres: its start, a round of alternating least squares, a step in space;
// in milliseconds, with the peak memory of the whole case.
//
//   fit_bench                                         2,000 to 50,000 vertices
//   fit_bench --large                                 also 200,000
//   fit_bench --benchmark_filter='fit_round/vertices:12500/shapes:36/threads:2'
//
// gflop_s: the products and solves of the formulas, over the time. gbyte_s of a round: each of its
// three passes reads all features once, in float. layer: the part of a step that the linear layer
// and its adjoint take.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <vector>

#include "banded_sphere.h"
#include "mscomp/acap/feature_layer.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/parallel.h"
#include "multiscale/alternating_squares.h"
#include "multiscale/ball_start.h"
#include "multiscale/space_descent.h"
#include "peak_memory.h"
#include "run_benchmarks.h"

namespace mscomp {
namespace {

using Clock = std::chrono::steady_clock;

struct Size {
    int vertices, shapes, threads;
};

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Smooth features of a sphere: twelve waves that turn it, each by a code of its own per shape.
class Problem {
  public:
    explicit Problem(const Size& size)
        : mesh_(banded_sphere(size.vertices)),
          distances_(mesh_.vertices),
          rows_(size.vertices, size.shapes) {
        set_thread_count(size.threads);
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            scale_.offset[c] = static_cast<double>(kReferenceFeature[c]);
        }
        fill();
        const auto begin = Clock::now();
        components_ = std::make_unique<BallComponents>(start_balls(rows_, settings_, distances_));
        start_seconds_ = seconds_since(begin);
    }
    ~Problem() { set_thread_count(0); }
    Problem(const Problem&) = delete;
    Problem& operator=(const Problem&) = delete;

    const TriangleMesh& mesh() const { return mesh_; }
    const MetricScale& scale() const { return scale_; }
    const MetricRows& rows() const { return rows_; }
    const MultiscaleSettings& settings() const { return settings_; }
    BallComponents& components() { return *components_; }
    double start_seconds() const { return start_seconds_; }

    /// Multiplications and additions of a round: three products with all features, a factor of G
    /// and nine solves at each vertex.
    double round_flops() const {
        double flops = 0;
        for (int v = 0; v < mesh_.vertex_count(); ++v) {
            const auto acting = static_cast<double>(components_->at_vertex(v).size());
            flops += 3 * 18.0 * acting * rows_.shape_count() + 18 * acting * acting +
                     acting * acting * acting / 3 + 18 * acting * acting;
        }
        return flops;
    }

  private:
    void fill() {
        const CounterRandom random(4, 0);
        std::vector<float> row(static_cast<std::size_t>(mesh_.vertex_count()) * kFeatureDim);
        for (int m = 0; m < rows_.shape_count(); ++m) {
            for (std::size_t i = 0; i < row.size(); ++i) {
                const Point& p = mesh_.vertices[i / kFeatureDim];
                double value = 0;
                for (std::uint64_t wave = 0; wave < 4; ++wave) {
                    const auto code = random.normal(static_cast<std::uint64_t>(m) * 12 + wave);
                    value += 0.05 * code *
                             std::sin((1 + static_cast<double>(wave)) * p[i % 3] +
                                      static_cast<double>(i % kFeatureDim));
                }
                row[i] = static_cast<float>(value);
            }
            rows_.set(m, row);
        }
    }

    MultiscaleSettings settings_;
    TriangleMesh mesh_;
    SphereRows distances_;
    MetricScale scale_;
    MetricRows rows_;
    std::unique_ptr<BallComponents> components_;
    double start_seconds_ = 0;
};

void fit_round(benchmark::State& state, const Size& size) {
    forget_peak_memory();
    Problem problem(size);
    const AlternatingSquares squares(
        one_rings_of_faces(problem.mesh().vertex_count(), problem.mesh().faces), problem.scale(),
        problem.settings().damping);
    double seconds = 0, rounds = 0;
    for (auto _ : state) {
        const auto begin = Clock::now();
        const double error = squares.round(problem.rows(), problem.components());
        const double spent = seconds_since(begin);
        state.SetIterationTime(spent);
        seconds += spent;
        ++rounds;
        if (!std::isfinite(error)) state.SkipWithError("the error is not finite");
    }
    const double bytes = 3.0 * 4 * static_cast<double>(problem.rows().all().size());
    state.counters["start_ms"] = 1e3 * problem.start_seconds();
    state.counters["gflop_s"] = 1e-9 * problem.round_flops() * rounds / seconds;
    state.counters["gbyte_s"] = 1e-9 * bytes * rounds / seconds;
    state.counters["peak_mib"] = peak_memory_mib();
}

/// Seconds that the layer and its adjoint take for all shapes.
double layer_seconds(const Problem& problem) {
    const FeatureLayer layer(problem.mesh(), EdgeWeights::cotangent, LayerEquations::tangential);
    const std::size_t row = static_cast<std::size_t>(problem.mesh().vertex_count());
    const auto shapes = static_cast<std::size_t>(problem.rows().shape_count());
    std::vector<double> features(shapes * row * kFeatureDim), gradients(features.size());
    for (std::size_t i = 0; i < features.size(); ++i) features[i] = kReferenceFeature[i % 9];
    std::vector<double> positions(shapes * row * 3);
    layer.positions(features, positions);
    const auto begin = Clock::now();
    layer.positions(features, positions);
    layer.adjoint(features, positions, gradients);
    return seconds_since(begin);
}

void space_step(benchmark::State& state, const Size& size) {
    forget_peak_memory();
    Problem problem(size);
    const SpaceDescent descent(problem.mesh(), "cotangent", problem.scale(), problem.rows(),
                               problem.settings().feature_share);
    SpaceState space = descent.begin(problem.components());
    double seconds = 0, epochs = 0;
    for (auto _ : state) {
        const auto begin = Clock::now();
        const SpaceDescent::Report report = descent.run_epoch(1, problem.components(), space);
        const double spent = seconds_since(begin) / SpaceDescent::kSteps;
        state.SetIterationTime(spent);
        seconds += spent;
        ++epochs;
        if (!std::isfinite(report.total)) state.SkipWithError("the error is not finite");
    }
    state.counters["layer"] = layer_seconds(problem) * epochs / seconds;
    state.counters["peak_mib"] = peak_memory_mib();
}

void add_all(bool large) {
    for (const int vertices : {2000, 12500, 50000, 200000}) {
        if (vertices > 50000 && !large) continue;
        for (const int shapes : {4, 36, 72}) {
            for (const int threads : {1, 2}) {
                const Size size{vertices, shapes, threads};
                const std::string name =
                    fmt::format("vertices:{}/shapes:{}/threads:{}", vertices, shapes, threads);
                const auto add = [&](const char* what, auto run, int times) {
                    benchmark::RegisterBenchmark(
                        (std::string(what) + "/" + name).c_str(),
                        [run, size](benchmark::State& state) { run(state, size); })
                        ->UseManualTime()
                        ->Unit(benchmark::kMillisecond)
                        ->Iterations(times);
                };
                add("fit_round", fit_round, 5);
                add("space_step", space_step, 1);
            }
        }
    }
}

}  // namespace
}  // namespace mscomp

int main(int argc, char** argv) { return mscomp::run_benchmarks(argc, argv, mscomp::add_all); }

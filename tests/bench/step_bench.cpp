// SPDX-License-Identifier: MIT
// One training step (forward, backward, Adam, proximal step) of the default model, in milliseconds.
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "mscomp/nn/optimizer.h"
#include "mscomp/nn/stacked_model.h"
#include "mscomp/nn/start.h"
#include "shapes.h"

namespace mscomp::nn {
namespace {

/// Great-circle distances on the unit sphere, divided by pi.
class SphereDistances final : public DistanceRows {
  public:
    explicit SphereDistances(std::vector<Point> points)
        : points_(std::move(points)), rows_(points_.size()) {}
    int vertex_count() const override { return static_cast<int>(points_.size()); }
    std::span<const double> row(int vertex) override {
        std::vector<double>& row = rows_[static_cast<std::size_t>(vertex)];
        if (row.empty()) {
            const Point& p = points_[static_cast<std::size_t>(vertex)];
            for (const Point& q : points_) {
                const double cosine = p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
                row.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)) / std::numbers::pi);
            }
        }
        return row;
    }

  private:
    std::vector<Point> points_;
    std::vector<std::vector<double>> rows_;
};

/// Arguments: subdivisions of the icosphere, shapes, threads.
void step_of_the_default_model(benchmark::State& state) {
    const TriangleMesh mesh = shapes::icosphere(static_cast<int>(state.range(0)));
    const int shape_count = static_cast<int>(state.range(1));
    set_thread_count(static_cast<int>(state.range(2)));
    SphereDistances distances(mesh.vertices);
    StackedModel<float>::Options options;
    options.batch = shape_count;
    StackedModel<float> model({}, {}, one_rings_of_faces(mesh.vertex_count(), mesh.faces),
                              distances, options);
    start_random(model, 1);
    const CounterRandom random(1, 1);
    std::vector<float> features(static_cast<std::size_t>(shape_count * mesh.vertex_count() * 9));
    for (std::size_t i = 0; i < features.size(); ++i) {
        features[i] = static_cast<float>(1.9 * random.uniform(i) - 0.95);
    }
    std::vector<int> which(static_cast<std::size_t>(shape_count));
    std::iota(which.begin(), which.end(), 0);
    model.load_batch(std::span<const float>(features), std::span<const int>(which));
    std::int64_t step = 0;
    for (auto _ : state) {
        const float loss = model.forward();
        if (!std::isfinite(loss)) {
            state.SkipWithError("the loss is not finite");
            break;
        }
        model.parameters().zero_grad();
        model.backward();
        adam_step(model.parameters(), 1e-3, ++step);
        proximal_step(model, 1000, 1e-3, step);
    }
    set_thread_count(0);
    state.counters["vertices"] = mesh.vertex_count();
}

BENCHMARK(step_of_the_default_model)
    ->ArgNames({"subdivisions", "shapes", "threads"})
    ->ArgsProduct({{4, 5}, {5, 36}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mscomp::nn

BENCHMARK_MAIN();

// SPDX-License-Identifier: MIT
// Time per shape of the choice of turns (src/acap/consistency.h), one thread.
#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "acap/deformation_gradient.h"
#include "acap/polar.h"
#include "acap/rotation.h"
#include "acap/turns/consistency.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/base/random.h"
#include "shapes.h"

namespace mscomp {
namespace {

using Field = std::vector<Eigen::Vector3d>;

struct Problems {
    ConsistencyGraph graph;
    std::vector<Field> shapes;  // principal logarithms
};

Problems problems_of(const MeshSequence& sequence, bool align) {
    const TriangleMesh reference{sequence.shapes.front(), sequence.faces};
    const DeformationGradients gradients(reference, EdgeWeights::cotangent);
    Problems problems;
    std::vector<double> unrest(reference.vertices.size(), 0.0);
    for (std::size_t n = 1; n < sequence.shapes.size(); ++n) {
        const std::vector<Point>& shape = sequence.shapes[n];
        const std::vector<Point> placed =
            align ? moved(shape, best_rigid_motion(shape, reference.vertices)) : shape;
        Field logs;
        for (const Eigen::Matrix3d& gradient : gradients.compute(placed).gradients) {
            logs.push_back(rotation_log(polar_decomposition(gradient).rotation));
            unrest[logs.size() - 1] += logs.back().norm();
        }
        problems.shapes.push_back(std::move(logs));
    }
    problems.graph = consistency_graph(gradients.rings(), unrest);
    return problems;
}

/// A slender bar, twisted by `turns`; positions moved by up to `noise` edge lengths.
Problems twisted_bar(int vertices, double turns, double noise) {
    constexpr double kLength = 10, kRadius = 0.05;
    const int around = static_cast<int>(std::lround(std::sqrt(vertices / 6.25)));
    const TriangleMesh bar =
        shapes::cylinder(around, (vertices - 2) / around, kRadius, kLength, true);
    const double edge = 2 * std::numbers::pi * kRadius / around;
    MeshSequence sequence;
    sequence.faces = bar.faces;
    sequence.shapes = {bar.vertices, bar.vertices};
    const CounterRandom random(5, 1);
    std::uint64_t draw = 0;
    for (Point& p : sequence.shapes[1]) {
        const double angle = 2 * std::numbers::pi * turns * p[2] / kLength;
        p = {std::cos(angle) * p[0] - std::sin(angle) * p[1],
             std::sin(angle) * p[0] + std::cos(angle) * p[1], p[2]};
        for (double& x : p) x += noise * edge * (2 * random.uniform(draw++) - 1);
    }
    return problems_of(sequence, false);
}

void solve_all(benchmark::State& state, const Problems& problems) {
    double gap = 0, principal = 0, energy = 0;
    int proved = 0;
    for (Field r : problems.shapes) {
        const ConsistencySummary summary = make_consistent(problems.graph, r);
        if (summary.energy > std::min(summary.principal_energy, summary.propagation_energy)) {
            state.SkipWithError("above a start");
        }
        gap += summary.energy - summary.lower_bound;
        principal += summary.principal_energy;
        energy += summary.energy;
        proved += summary.energy <= summary.lower_bound * (1 + 1e-9) + 1e-9 ? 1 : 0;
    }
    for (auto _ : state) {
        state.PauseTiming();
        std::vector<Field> shapes = problems.shapes;
        state.ResumeTiming();
        for (Field& r : shapes) benchmark::DoNotOptimize(make_consistent(problems.graph, r));
    }
    const auto count = static_cast<double>(problems.shapes.size());
    state.counters["vertices"] = static_cast<double>(problems.shapes.front().size());
    state.counters["shapes"] = count;
    state.counters["proved"] = proved;
    state.counters["gap"] = gap;
    state.counters["energy_principal"] = principal;
    state.counters["energy"] = energy;
    state.counters["seconds_per_shape"] = benchmark::Counter(
        count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// Arguments: vertices, turns times ten, noise in percent of an edge.
void bar(benchmark::State& state) {
    solve_all(state, twisted_bar(static_cast<int>(state.range(0)),
                                 static_cast<double>(state.range(1)) / 10,
                                 static_cast<double>(state.range(2)) / 100));
}
BENCHMARK(bar)
    ->ArgsProduct({{10000, 100000}, {5, 25, 50}, {0, 20}})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();

void register_real_sets() {
    for (const std::string name : {"scape", "horse", "samba", "hand", "camel"}) {
        const std::string folder = MSCOMP_SHARED_DIR "/data/" + name;
        if (!std::filesystem::exists(folder)) continue;
        benchmark::RegisterBenchmark(name.c_str(), [folder](benchmark::State& state) {
            solve_all(state, problems_of(read_sequence(expand_inputs({folder})), true));
        })->Unit(benchmark::kMillisecond);
    }
}

}  // namespace
}  // namespace mscomp

int main(int argc, char** argv) {
    mscomp::register_real_sets();
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}

// SPDX-License-Identifier: MIT
// Geodesic rows one at a time and eight at a time, both on one thread, the factorisations, and the
// normaliser. Rows are compared bit for bit before they are timed. With --large also at a million
// vertices.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "mscomp/base/parallel.h"
#include "mscomp/generate/generate.h"
#include "mscomp/geodesic/heat_geodesics.h"
#include "run_benchmarks.h"

namespace mscomp {
namespace {

constexpr std::int64_t kBatch = 8;

const TriangleMesh& arm_with(std::int64_t vertices) {
    static std::map<std::int64_t, TriangleMesh> all;
    TriangleMesh& mesh = all[vertices];
    if (mesh.vertices.empty()) {
        GeneratedSequence generated = generate_arm(2, 0, static_cast<int>(vertices));
        mesh = {std::move(generated.sequence.shapes[0]), std::move(generated.sequence.faces)};
    }
    return mesh;
}

const HeatGeodesics& geodesics_of(std::int64_t vertices) {
    static std::map<std::int64_t, std::unique_ptr<HeatGeodesics>> all;
    auto& geodesics = all[vertices];
    if (!geodesics) geodesics = std::make_unique<HeatGeodesics>(arm_with(vertices));
    return *geodesics;
}

std::vector<int> sources(const HeatGeodesics& geodesics) {
    std::vector<int> result;
    for (std::int64_t k = 0; k < kBatch; ++k) {
        result.push_back(static_cast<int>(geodesics.vertex_count() * k / kBatch));
    }
    return result;
}

void require_equal_rows(const HeatGeodesics& geodesics) {
    const std::vector<int> from = sources(geodesics);
    const auto rows = geodesics.distance_rows(from);
    for (std::size_t k = 0; k < from.size(); ++k) {
        if (rows[k] != geodesics.distances(from[k])) {
            throw std::runtime_error("a row of a batch differs from the same row by itself");
        }
    }
}

void factorise(benchmark::State& state) {
    const TriangleMesh& mesh = arm_with(state.range(0));
    for (auto _ : state) benchmark::DoNotOptimize(HeatGeodesics(mesh).vertex_count());
}

void one_row(benchmark::State& state) {
    const HeatGeodesics& geodesics = geodesics_of(state.range(0));
    require_equal_rows(geodesics);
    const std::vector<int> from = sources(geodesics);
    std::size_t next = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(geodesics.distances(from[next++ % from.size()]));
    }
    state.SetItemsProcessed(state.iterations());
}

void eight_rows(benchmark::State& state) {
    const HeatGeodesics& geodesics = geodesics_of(state.range(0));
    const std::vector<int> from = sources(geodesics);
    for (auto _ : state) benchmark::DoNotOptimize(geodesics.distance_rows(from));
    state.SetItemsProcessed(state.iterations() * kBatch);
}

void normalizer(benchmark::State& state) {
    const HeatGeodesics& geodesics = geodesics_of(state.range(0));
    for (auto _ : state) benchmark::DoNotOptimize(geodesic_normalizer(geodesics).largest_distance);
}

void add(const std::string& name, void (*body)(benchmark::State&), bool large) {
    auto* added = benchmark::RegisterBenchmark(name.c_str(), body);
    added->Unit(benchmark::kMillisecond)->Arg(12'500)->Arg(100'000);
    if (large) added->Arg(1'000'000);
}

}  // namespace
}  // namespace mscomp

int main(int argc, char** argv) {
    mscomp::set_thread_count(1);
    return mscomp::run_benchmarks(argc, argv, [](bool large) {
        mscomp::add("factorise", mscomp::factorise, large);
        mscomp::add("one_row", mscomp::one_row, large);
        mscomp::add("eight_rows", mscomp::eight_rows, large);
        mscomp::add("normalizer", mscomp::normalizer, large);
    });
}

// SPDX-License-Identifier: MIT
// Every kernel with each instruction set of this processor and its plain loop, one thread, arrays
// of 36 shapes (48 lanes) as a step has them. Results are compared before anything is timed.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "kernel_cases.h"

namespace mscomp::nn {
namespace {

constexpr double kTolerance = 1e-4;  // sums of up to 2,500 x 9 x 48 floats in two orders

void report(benchmark::State& state, const KernelCase& what) {
    using benchmark::Counter;
    state.counters["flops"] = Counter(what.flops, Counter::kIsIterationInvariantRate);
    state.counters["bytes"] = Counter(what.bytes, Counter::kIsIterationInvariantRate);
}

void fast(benchmark::State& state, const KernelCase& what, const Kernels<float>& kernels) {
    const double apart = difference(what, kernels);
    if (!(apart <= kTolerance)) {
        state.SkipWithError(fmt::format("differs from the plain loop by {:.2g}", apart).c_str());
        return;
    }
    for (auto _ : state) {
        what.fast(kernels);
        benchmark::ClobberMemory();
    }
    report(state, what);
}

void plain(benchmark::State& state, const KernelCase& what) {
    for (auto _ : state) {
        what.plain();
        benchmark::ClobberMemory();
    }
    report(state, what);
}

void add_all(const KernelCases& cases) {
    for (const KernelCase& each : cases.all()) {
        const auto add = [&](const std::string& with, auto body) {
            benchmark::RegisterBenchmark(fmt::format("kernel/{}/{}", each.name, with).c_str(), body)
                ->Unit(benchmark::kMicrosecond);
        };
        add("plain", [&each](benchmark::State& state) { plain(state, each); });
        for (const char* name : {"generic", "avx2", "avx512"}) {
            const Kernels<float>* found = find_kernels<float>(name);
            if (found == nullptr) continue;
            add(name, [&each, found](benchmark::State& state) { fast(state, each, *found); });
        }
    }
}

}  // namespace
}  // namespace mscomp::nn

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    const mscomp::nn::KernelCases cases({2500, 48, 10});
    mscomp::nn::add_all(cases);
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}

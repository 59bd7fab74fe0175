// SPDX-License-Identifier: MIT
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <string_view>

namespace mscomp {

/// The whole of main for benchmarks whose sizes depend on --large: add_all(is_large), then run.
template <class AddAll>
int run_benchmarks(int argc, char** argv, const AddAll& add_all) {
    const auto is_large = [](const char* argument) {
        return std::string_view(argument) == "--large";
    };
    char** const end = std::remove_if(argv + 1, argv + argc, is_large);
    int count = static_cast<int>(end - argv);
    add_all(count < argc);
    benchmark::Initialize(&count, argv);
    if (benchmark::ReportUnrecognizedArguments(count, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}

}  // namespace mscomp

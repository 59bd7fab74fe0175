// SPDX-License-Identifier: MIT
#include "kernels.h"

#include <fmt/format.h>

#include <cstdlib>
#include <string_view>

#include "mscomp/base/error.h"

namespace mscomp::nn {

template <class T>
const Kernels<T>* find_kernels(const char* instruction_set) {
    const std::string_view wanted = instruction_set;
    static const Kernels<T> generic = isa_generic::table<T>();
    if (wanted == "generic") return &generic;
#if defined(__x86_64__)
    if (wanted == "avx2" && __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
        static const Kernels<T> avx2 = isa_avx2::table<T>();
        return &avx2;
    }
    if (wanted == "avx512" && __builtin_cpu_supports("avx512f") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512bw")) {
        static const Kernels<T> avx512 = isa_avx512::table<T>();
        return &avx512;
    }
#endif
    return nullptr;
}

namespace {

template <class T>
const Kernels<T>& pick() {
    if (const char* wanted = std::getenv("MSCOMP_INSTRUCTION_SET")) {
        if (const Kernels<T>* found = find_kernels<T>(wanted)) return *found;
        throw UsageError(fmt::format(
            "MSCOMP_INSTRUCTION_SET={}: expected generic, avx2 or avx512, and a processor with it",
            wanted));
    }
    for (const char* candidate : {"avx512", "avx2"}) {
        if (const Kernels<T>* found = find_kernels<T>(candidate)) return *found;
    }
    return *find_kernels<T>("generic");
}

}  // namespace

template <class T>
const Kernels<T>& kernels() {
    static const Kernels<T>& chosen = pick<T>();
    return chosen;
}

template const Kernels<float>* find_kernels<float>(const char*);
template const Kernels<double>* find_kernels<double>(const char*);
template const Kernels<float>& kernels<float>();
template const Kernels<double>& kernels<double>();

}  // namespace mscomp::nn

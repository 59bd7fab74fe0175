// SPDX-License-Identifier: MIT
// Where libFuzzer enters; MSCOMP_FUZZ_TARGET is the name of a target.
#include <string_view>

#include "fuzz/targets.h"

namespace {

constexpr const mscomp::fuzz::Target& named(std::string_view name) {
    for (const mscomp::fuzz::Target& target : mscomp::fuzz::kTargets) {
        if (name == target.name) return target;
    }
    throw "no such target";
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr const mscomp::fuzz::Target& target = named(MSCOMP_FUZZ_TARGET);
    mscomp::fuzz::run_target(target, data, size);
    return 0;
}

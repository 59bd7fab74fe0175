// SPDX-License-Identifier: MIT
// Where libFuzzer enters. One program for all targets: called fuzz_obj it runs the target obj.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "fuzz/mutators.h"
#include "fuzz/targets.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

const mscomp::fuzz::Target* target = nullptr;
mscomp::fuzz::Mutate mutate = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*count*/, char*** arguments) {
    std::string_view name = **arguments;
    name.remove_prefix(std::min(name.rfind("fuzz_") + std::strlen("fuzz_"), name.size()));
    for (const mscomp::fuzz::Target& each : mscomp::fuzz::kTargets) {
        if (name == each.name) target = &each;
    }
    if (target == nullptr) {
        std::fprintf(stderr, "%s: called by no target's name\n", **arguments);
        std::exit(2);
    }
    mutate = mscomp::fuzz::mutate_of(name);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    mscomp::fuzz::run_target(*target, data, size);
    return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
    if (mutate != nullptr) {
        const std::string_view file(reinterpret_cast<const char*>(data), size);
        const auto changed = mutate(file, most, seed);
        if (changed && changed->size() <= most) {
            std::copy(changed->begin(), changed->end(), data);
            return changed->size();
        }
    }
    return LLVMFuzzerMutate(data, size, most);
}

std::string mscomp::fuzz::changed(std::string text, std::size_t most) {
    const std::size_t size = std::min(text.size(), most);
    text.resize(std::max<std::size_t>(most, 1));
    text.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(text.data()), size, text.size()));
    return text;
}

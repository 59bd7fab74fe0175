// SPDX-License-Identifier: MIT
// Where libFuzzer enters. One program for all targets: called fuzz_obj it runs the target obj.
#include <sanitizer/allocator_interface.h>

#include <algorithm>
#include <atomic>
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

// What an input makes us hold at once. libFuzzer's own limits are those of one allocation and of
// the whole process; where that is reached it may never come to write the input.
constexpr std::int64_t kMostBytesHeld = std::int64_t{256} << 20;
std::atomic<std::int64_t> bytes_held = 0;
std::atomic<std::int64_t> bytes_held_before = 0;

void note_allocation(const volatile void* /*memory*/, std::size_t size) {
    const auto bytes = static_cast<std::int64_t>(size);
    const std::int64_t held = bytes_held.fetch_add(bytes, std::memory_order_relaxed) + bytes;
    if (held - bytes_held_before < kMostBytesHeld) return;
    bytes_held_before = held;  // aborting allocates
    std::fputs("an input holds more than 256 MB at once\n", stderr);
    std::abort();
}

void note_release(const volatile void* memory) {
    const auto size = __sanitizer_get_allocated_size(const_cast<const void*>(memory));
    bytes_held.fetch_sub(static_cast<std::int64_t>(size), std::memory_order_relaxed);
}

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
    __sanitizer_install_malloc_and_free_hooks(note_allocation, note_release);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    bytes_held_before = bytes_held.load();
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

// SPDX-License-Identifier: MIT
#include "fuzz/targets.h"

#include <ctime>

#include "fuzz/promises.h"
#include "mscomp/base/parallel.h"

namespace mscomp::fuzz {

void run_target(const Target& target, const std::uint8_t* data, std::size_t size) {
    set_thread_count(1);  // a finding has to come again
    const std::clock_t start = std::clock();
    target.check(std::as_bytes(std::span<const std::uint8_t>(data, size)));
    require(std::clock() - start < CLOCKS_PER_SEC, "a small input takes less than a second");
}

}  // namespace mscomp::fuzz

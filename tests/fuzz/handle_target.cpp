// SPDX-License-Identifier: MIT
#include <cmath>
#include <set>

#include "cli/acapfeat/handle_file.h"
#include "fuzz/memory_file.h"
#include "fuzz/promises.h"
#include "fuzz/targets.h"

namespace mscomp::fuzz {

void check_handles(std::span<const std::byte> input) {
    constexpr int kVertexCount = 10;
    static const MemoryFile memory;
    const std::string path = memory.filled_with(input);
    const auto handles = unless_refused(path, [&] { return read_handles(path, kVertexCount); });
    if (!handles) return;
    require(!handles->empty(), "there is a handle");
    std::set<int> vertices;
    for (const Handle& handle : *handles) {
        require(handle.vertex >= 0 && handle.vertex < kVertexCount, "handles refer to vertices");
        require(vertices.insert(handle.vertex).second, "a vertex has one handle");
        require(handle.weight > 0, "weights are positive");
        for (const double x : handle.position) require(std::isfinite(x), "positions are finite");
    }
}

}  // namespace mscomp::fuzz

// SPDX-License-Identifier: MIT
#include "nn/active_vertices.h"

#include <algorithm>

#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp::nn {
namespace {

std::span<const int> ring(const OneRings& rings, int vertex) {
    const auto first = at(rings.offsets[at(vertex)]), last = at(rings.offsets[at(vertex) + 1]);
    return std::span(rings.neighbors).subspan(first, last - first);
}

}  // namespace

ActiveVertices ActiveVertices::around(const OneRings& rings, std::span<const std::uint8_t> acts) {
    ActiveVertices active;
    active.slot_of.assign(acts.size(), -1);
    constexpr int kTouched = 0;
    for (int v = 0; v < rings.vertex_count(); ++v) {
        if (acts[at(v)] == 0) continue;
        active.slot_of[at(v)] = kTouched;
        for (const int j : ring(rings, v)) active.slot_of[at(j)] = kTouched;
    }
    for (int v = 0; v < rings.vertex_count(); ++v) {
        if (active.slot_of[at(v)] < 0) continue;
        active.slot_of[at(v)] = active.slot_count();
        if (acts[at(v)] != 0) {
            active.acting.push_back(active.slot_count());
            active.acting_vertices.push_back(v);
        }
        active.vertices.push_back(v);
    }
    active.ring_offsets.push_back(0);
    for (const int v : active.vertices) {
        for (const int j : ring(rings, v)) {
            if (active.slot_of[at(j)] >= 0) active.ring_slots.push_back(active.slot_of[at(j)]);
        }
        active.ring_offsets.push_back(static_cast<int>(active.ring_slots.size()));
    }
    return active;
}

ActiveVertices ActiveVertices::all(const OneRings& rings) {
    return around(rings, std::vector<std::uint8_t>(at(rings.vertex_count()), 1));
}

bool ActiveVertices::acts(int vertex) const {
    return std::ranges::binary_search(acting_vertices, vertex);
}

LevelSupports::LevelSupports(const OneRings& rings, int autoencoders)
    : rings_(rings), active_(at(autoencoders), ActiveVertices::all(rings)) {}

void LevelSupports::set(std::span<const std::uint8_t> acts) {
    const std::size_t vertices = at(rings_.vertex_count());
    parallel_for(count(), [&](std::int64_t a) {
        active_[at(a)] = ActiveVertices::around(rings_, acts.subspan(at(a) * vertices, vertices));
    });
    ++revision_;
}

}  // namespace mscomp::nn

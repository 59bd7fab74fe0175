// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// What the integer search needs of the connectivity, shared by all shapes.
struct ConsistencyGraph {
    OneRings rings;
    std::vector<int> reverse;               // beside rings.neighbors: the place of the way back
    std::vector<std::array<int, 2>> edges;  // undirected, first < second, ascending
    std::vector<int> component;             // (V)
    std::vector<int> roots;                 // one vertex per component: its turn stays 0
};

/// Edges of `rings`, and as root of every component its vertex of least `unrest` (V); within 1e-4
/// of the least the lowest index.
ConsistencyGraph consistency_graph(OneRings rings, const std::vector<double>& unrest);

}  // namespace mscomp

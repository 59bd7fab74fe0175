// SPDX-License-Identifier: MIT
#include "heat_matrices.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

/// Cotangent weights are raised to this in the heat step: with a negative one heat may change sign,
/// and then distances are wrong by half. The energy of the Poisson step is a sum of energies >= 0
/// whatever the signs and needs no such thing.
constexpr double kSmallestHeatWeight = 1e-3;

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Lower triangle of diagonal + Σ weight_e factor_e over the edges' Laplacians; rows with `fixed`
/// set become those of the identity.
template <class WeightOf>
SparseMatrix assemble(const std::vector<double>& diagonal, std::span<const IntrinsicEdge> edges,
                      const WeightOf& weight_of, const std::vector<bool>& fixed) {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(edges.size() * 3 + fixed.size());
    const auto add = [&](int i, int j, double value) {
        if (fixed[at(i)] || fixed[at(j)]) return;
        entries.emplace_back(i, j, value);
    };
    for (const IntrinsicEdge& edge : edges) {
        if (edge.i == edge.j) continue;  // flips make such edges; they join nothing
        const double weight = weight_of(edge);
        add(edge.i, edge.i, weight);
        add(edge.j, edge.j, weight);
        add(edge.j, edge.i, -weight);
    }
    for (std::size_t i = 0; i < fixed.size(); ++i) {
        const int row = static_cast<int>(i);
        entries.emplace_back(row, row, fixed[i] ? 1.0 : diagonal[i]);
    }
    const auto size = static_cast<Eigen::Index>(fixed.size());
    SparseMatrix matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

/// Neighbours of every vertex and the lengths of the edges to them.
struct EdgeGraph {
    explicit EdgeGraph(int vertex_count, std::span<const IntrinsicEdge> edges)
        : offsets(at(vertex_count) + 1, 0), ends(2 * edges.size()) {
        for (const IntrinsicEdge& edge : edges) {
            ++offsets[at(edge.i) + 1];
            ++offsets[at(edge.j) + 1];
        }
        for (std::size_t i = 1; i < offsets.size(); ++i) offsets[i] += offsets[i - 1];
        std::vector<std::size_t> next(offsets.begin(), offsets.end() - 1);
        for (const IntrinsicEdge& edge : edges) {
            ends[next[at(edge.i)]++] = {edge.j, edge.length};
            ends[next[at(edge.j)]++] = {edge.i, edge.length};
        }
    }

    std::vector<std::size_t> offsets;
    std::vector<std::pair<int, double>> ends;
};

/// (V) shortest paths along edges from the nearest of `sources` (Dijkstra).
std::vector<double> path_lengths(const EdgeGraph& graph, const std::vector<int>& sources) {
    std::vector<double> lengths(graph.offsets.size() - 1, std::numeric_limits<double>::infinity());
    using Front = std::pair<double, int>;
    std::priority_queue<Front, std::vector<Front>, std::greater<>> fronts;
    for (const int source : sources) {
        lengths[at(source)] = 0;
        fronts.emplace(0.0, source);
    }
    while (!fronts.empty()) {
        const auto [length, vertex] = fronts.top();
        fronts.pop();
        const auto place = at(vertex);
        if (length > lengths[place]) continue;
        for (std::size_t k = graph.offsets[place]; k < graph.offsets[place + 1]; ++k) {
            const auto [end, step] = graph.ends[k];
            double& known = lengths[at(end)];
            if (length + step >= known) continue;
            known = length + step;
            fronts.emplace(known, end);
        }
    }
    return lengths;
}

/// In every component the vertex with the largest entry, the lowest on ties.
std::vector<int> farthest_in_each(const std::vector<double>& lengths,
                                  const std::vector<int>& component) {
    std::vector<int> farthest;
    for (std::size_t i = 0; i < lengths.size(); ++i) {
        const auto c = at(component[i]);
        if (c == farthest.size()) {
            farthest.push_back(static_cast<int>(i));
        } else if (lengths[i] > lengths[at(farthest[c])]) {
            farthest[c] = static_cast<int>(i);
        }
    }
    return farthest;
}

}  // namespace

std::vector<IntrinsicEdge> intrinsic_edges(const IntrinsicTriangles& surface) {
    std::vector<IntrinsicEdge> edges;
    edges.reserve(surface.triangles.size() * 3);
    for (const FlatTriangle& triangle : surface.triangles) {
        const std::array<double, 3> cotangents = triangle.cotangents();
        const std::array<double, 3> lengths{std::hypot(triangle.base - triangle.x, triangle.y),
                                            std::hypot(triangle.x, triangle.y), triangle.base};
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [i, j] =
                std::minmax(triangle.corners[(k + 1) % 3], triangle.corners[(k + 2) % 3]);
            edges.push_back({i, j, 0.5 * cotangents[k], lengths[k]});
        }
    }
    std::stable_sort(edges.begin(), edges.end(),
                     [](const IntrinsicEdge& a, const IntrinsicEdge& b) {
                         return a.i != b.i ? a.i < b.i : a.j < b.j;
                     });
    std::size_t count = 0;
    for (const IntrinsicEdge& edge : edges) {
        if (count > 0 && edges[count - 1].i == edge.i && edges[count - 1].j == edge.j) {
            edges[count - 1].weight += edge.weight;
            edges[count - 1].length = std::min(edges[count - 1].length, edge.length);
        } else {
            edges[count++] = edge;
        }
    }
    edges.resize(count);
    return edges;
}

std::vector<double> component_extents(const IntrinsicTriangles& surface,
                                      std::span<const IntrinsicEdge> edges) {
    const EdgeGraph graph(surface.vertex_count, edges);
    const std::vector<double> nothing(surface.component.size(), 0.0);
    const std::vector<int> lowest = farthest_in_each(nothing, surface.component);
    const std::vector<int> rim = farthest_in_each(path_lengths(graph, lowest), surface.component);
    const std::vector<double> lengths = path_lengths(graph, rim);
    std::vector<double> extents;
    for (const int vertex : farthest_in_each(lengths, surface.component)) {
        extents.push_back(lengths[at(vertex)]);
    }
    return extents;
}

SparseMatrix heat_matrix(const IntrinsicTriangles& surface, std::span<const IntrinsicEdge> edges,
                         std::span<const double> time, const std::vector<bool>& lonely) {
    const auto weight_of = [&](const IntrinsicEdge& edge) {
        const auto component = at(surface.component[at(edge.i)]);
        return time[component] * std::max(edge.weight, kSmallestHeatWeight);
    };
    return assemble(lumped_mass(surface), edges, weight_of, lonely);
}

SparseMatrix poisson_matrix(std::span<const IntrinsicEdge> edges,
                            const std::vector<bool>& anchored) {
    const auto weight_of = [](const IntrinsicEdge& edge) { return edge.weight; };
    return assemble(std::vector<double>(anchored.size(), 0.0), edges, weight_of, anchored);
}

}  // namespace mscomp

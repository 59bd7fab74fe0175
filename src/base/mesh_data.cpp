// SPDX-License-Identifier: MIT
#include "mscomp/base/mesh_data.h"

#include <algorithm>

#include "mscomp/base/index.h"

namespace mscomp {

std::vector<Point> points_of(std::span<const float> coordinates) {
    std::vector<Point> points(coordinates.size() / 3);
    for (std::size_t i = 0; i < 3 * points.size(); ++i) {
        points[i / 3][i % 3] = static_cast<double>(coordinates[i]);
    }
    return points;
}

OneRings one_rings_of_faces(int vertex_count, const std::vector<Face>& faces) {
    std::vector<std::array<int, 2>> edges;
    edges.reserve(faces.size() * 6);
    for (const Face& face : faces) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const int a = face[corner];
            const int b = face[(corner + 1) % 3];
            if (a == b) continue;
            edges.push_back({a, b});
            edges.push_back({b, a});
        }
    }
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());

    OneRings rings;
    rings.offsets.assign(at(vertex_count) + 1, 0);
    rings.neighbors.reserve(edges.size());
    for (const auto& [from, to] : edges) {
        ++rings.offsets[at(from) + 1];
        rings.neighbors.push_back(to);
    }
    for (std::size_t i = 1; i < rings.offsets.size(); ++i) rings.offsets[i] += rings.offsets[i - 1];
    return rings;
}

std::vector<int> connected_components(const OneRings& rings) {
    const int count = rings.vertex_count();
    std::vector<int> component(at(count), -1);
    std::vector<int> stack;
    int next = 0;
    for (int seed = 0; seed < count; ++seed) {
        if (component[at(seed)] >= 0) continue;
        component[at(seed)] = next;
        stack.assign(1, seed);
        while (!stack.empty()) {
            const auto vertex = at(stack.back());
            stack.pop_back();
            for (int place = rings.offsets[vertex]; place < rings.offsets[vertex + 1]; ++place) {
                const int neighbor = rings.neighbors[at(place)];
                if (component[at(neighbor)] >= 0) continue;
                component[at(neighbor)] = next;
                stack.push_back(neighbor);
            }
        }
        ++next;
    }
    return component;
}

}  // namespace mscomp

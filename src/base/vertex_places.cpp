// SPDX-License-Identifier: MIT
#include "mscomp/base/vertex_places.h"

#include <fmt/format.h>

#include <utility>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

std::vector<char> used_by(const std::vector<Face>& faces, std::size_t vertex_count) {
    std::vector<char> used(vertex_count, 0);
    for (const Face& face : faces) {
        for (const int corner : face) used[at(corner)] = 1;
    }
    return used;
}

}  // namespace

VertexPlaces::VertexPlaces(const std::vector<int>& coincident, const std::vector<Face>& faces) {
    const std::vector<char> used = used_by(faces, coincident.size());
    place_.assign(coincident.size(), -1);
    for (std::size_t v = 0; v < coincident.size(); ++v) {
        if (used[v] == 0) continue;
        int& first = place_[at(coincident[v])];
        if (first < 0) {
            first = static_cast<int>(lowest_.size());
            lowest_.push_back(static_cast<int>(v));
        }
        place_[v] = first;
    }
    if (lowest_.size() < place_.size()) return;
    place_.clear();
    lowest_.clear();
}

VertexPlaces VertexPlaces::from_stored(std::vector<int> place, const std::vector<Face>& faces) {
    VertexPlaces result;
    for (std::size_t v = 0; v < place.size(); ++v) {
        const int most = static_cast<int>(result.lowest_.size());
        if (place[v] < -1 || place[v] > most) {
            throw MeshError(fmt::format("place[{}] is {}, wanted -1 to {}", v, place[v], most));
        }
        if (place[v] == most) result.lowest_.push_back(static_cast<int>(v));
    }
    result.place_ = std::move(place);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        for (const int corner : faces[f]) {
            if (result.place(corner) >= 0) continue;
            throw MeshError(fmt::format("faces[{}] uses vertex {}, whose place is -1", f, corner));
        }
    }
    return result;
}

int VertexPlaces::unused_count() const { return static_cast<int>(std::ranges::count(place_, -1)); }

int VertexPlaces::coincident_count() const {
    return static_cast<int>(place_.size() - lowest_.size()) - unused_count();
}

std::vector<Face> VertexPlaces::joined(std::vector<Face> faces) const {
    for (Face& face : faces) {
        for (int& corner : face) corner = vertex(place(corner));
    }
    return faces;
}

TriangleMesh VertexPlaces::surface(const TriangleMesh& mesh) const {
    if (are_all_vertices()) return mesh;
    TriangleMesh result{of_places(std::span(mesh.vertices)), mesh.faces};
    for (Face& face : result.faces) {
        for (int& corner : face) corner = place(corner);
    }
    return result;
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "connectivity_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <tuple>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

class DisjointSets {
  public:
    explicit DisjointSets(std::size_t count) : parent_(count) {
        std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    }
    std::size_t find(std::size_t x) {
        while (parent_[x] != x) x = parent_[x] = parent_[parent_[x]];
        return x;
    }
    void join(std::size_t x, std::size_t y) { parent_[find(x)] = find(y); }

  private:
    std::vector<std::size_t> parent_;
};

/// A side of a face: the edge low - high, passed upwards or downwards.
struct Side {
    int low, high;
    bool upwards;
    bool operator<(const Side& other) const {
        return std::tie(low, high, upwards) < std::tie(other.low, other.high, other.upwards);
    }
};

std::string counted(int count, std::string_view one, std::string_view many) {
    return fmt::format("{} {}", count, count == 1 ? one : many);
}

class ReportBuilder {
  public:
    ReportBuilder(const std::vector<Face>& faces, const std::vector<Face>& joined,
                  const std::vector<int>& face_numbers, const SurfaceMesh& mesh)
        : faces_(faces),
          joined_(joined),
          numbers_(face_numbers),
          mesh_(mesh),
          rings_(mesh.rings()) {}

    ConnectivityReport build() {
        report_.vertex_count = rings_.vertex_count();
        report_.face_count = static_cast<int>(faces_.size());
        report_.faces_beside = static_cast<int>(mesh_.faces_beside().size());
        count_degenerate_faces();
        count_duplicate_faces();
        count_boundaries();
        count_non_manifold_edges();
        count_vertex_fans();
        count_components();
        count_isolated_vertices();
        return std::move(report_);
    }

  private:
    /// Of a triangle, in the file.
    int number(std::size_t face) const {
        return numbers_.empty() ? static_cast<int>(face) + 1 : numbers_[face];
    }

    void count_degenerate_faces() {
        int first = 0, last = 0;  // triangles of one polygon are neighbours
        for (std::size_t i = 0; i < faces_.size(); ++i) {
            if (!is_degenerate(faces_[i]) || number(i) == last) continue;
            last = number(i);
            if (report_.degenerate_faces++ == 0) first = last;
        }
        if (report_.degenerate_faces == 0) return;
        warn(counted(report_.degenerate_faces, "face has", "faces have") +
             fmt::format(" a vertex twice, the first is face {}", first));
    }

    void count_duplicate_faces() {
        std::vector<std::pair<Face, std::size_t>> sorted;
        for (std::size_t i = 0; i < faces_.size(); ++i) {
            Face face = faces_[i];
            std::sort(face.begin(), face.end());
            sorted.emplace_back(face, i);
        }
        std::sort(sorted.begin(), sorted.end());
        std::map<int, int> originals;  // by the number of the later face
        for (std::size_t i = 1, group = 0; i < sorted.size(); ++i) {
            if (sorted[i].first != sorted[group].first) {
                group = i;
                continue;
            }
            const int original = number(sorted[group].second), later = number(sorted[i].second);
            if (later != original) originals.try_emplace(later, original);
        }
        report_.duplicate_faces = static_cast<int>(originals.size());
        if (originals.empty()) return;
        warn(counted(report_.duplicate_faces, "face has", "faces have") +
             fmt::format(" the vertices of an earlier one, the first is face {}, as face {}",
                         originals.begin()->first, originals.begin()->second));
    }

    void count_boundaries() {
        const std::vector<std::array<int, 2>> edges = mesh_.boundary_edges();
        if (edges.empty()) return;
        DisjointSets loops(at(rings_.vertex_count()));
        for (const auto& [low, high] : edges) loops.join(at(low), at(high));
        std::vector<std::size_t> roots;
        for (const auto& [low, high] : edges) roots.push_back(loops.find(at(low)));
        std::sort(roots.begin(), roots.end());
        report_.boundary_edges = static_cast<int>(edges.size());
        report_.boundary_loops =
            static_cast<int>(std::unique(roots.begin(), roots.end()) - roots.begin());
        warn(counted(report_.boundary_loops, "boundary", "boundaries") +
             fmt::format(" of together {} edges, the first at vertex {}", report_.boundary_edges,
                         edges.front()[0] + 1));
    }

    void count_non_manifold_edges() {
        std::vector<Side> sides;
        sides.reserve(joined_.size() * 3);
        for (const Face& face : joined_) {
            if (is_degenerate(face)) continue;
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const int a = face[corner], b = face[(corner + 1) % 3];
                sides.push_back({std::min(a, b), std::max(a, b), a < b});
            }
        }
        std::sort(sides.begin(), sides.end());
        Side first{};
        for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
            const Side& side = sides[begin];
            while (end < sides.size() && sides[end].low == side.low &&
                   sides[end].high == side.high) {
                ++end;
            }
            if (end - begin == 1) continue;
            if (end - begin > 2 || side.upwards == sides[begin + 1].upwards) {
                if (report_.non_manifold_edges++ == 0) first = side;
            }
        }
        if (report_.non_manifold_edges == 0) return;
        warn(counted(report_.non_manifold_edges, "edge is", "edges are") +
             fmt::format(" not manifold (more than two faces, or two of opposite orientation), the "
                         "first between the vertices {} and {}",
                         first.low + 1, first.high + 1));
    }

    /// Place of `neighbor` in the ring of `vertex`, counted over all rings.
    std::size_t place(int vertex, int neighbor) const {
        const auto place = at(vertex);
        const auto begin = rings_.neighbors.begin() + rings_.offsets[place];
        const auto end = rings_.neighbors.begin() + rings_.offsets[place + 1];
        return at(std::lower_bound(begin, end, neighbor) - rings_.neighbors.begin());
    }

    /// The faces around a vertex form one fan exactly if their far edges connect its neighbours.
    void count_vertex_fans() {
        DisjointSets fans(rings_.neighbors.size());
        std::vector<char> in_face(rings_.neighbors.size(), 0);
        for (const Face& face : joined_) {
            if (is_degenerate(face)) continue;
            for (std::size_t corner = 0; corner < 3; ++corner) {
                const std::size_t next = place(face[corner], face[(corner + 1) % 3]);
                const std::size_t last = place(face[corner], face[(corner + 2) % 3]);
                in_face[next] = in_face[last] = 1;
                fans.join(next, last);
            }
        }
        int first = -1;
        for (int vertex = 0; vertex < rings_.vertex_count(); ++vertex) {
            const auto place = at(vertex);
            int count = 0;
            for (auto i = at(rings_.offsets[place]); i < at(rings_.offsets[place + 1]); ++i) {
                if (in_face[i] != 0 && fans.find(i) == i) ++count;
            }
            if (count < 2) continue;
            if (report_.non_manifold_vertices++ == 0) first = vertex;
        }
        if (report_.non_manifold_vertices == 0) return;
        warn(counted(report_.non_manifold_vertices, "vertex joins", "vertices join") +
             fmt::format(" surfaces that touch only there, the first is vertex {}", first + 1));
    }

    void count_components() {
        const std::vector<int> component = mesh_.components();
        std::vector<int> used;
        for (const Face& face : joined_) {
            for (const int corner : face) used.push_back(component[at(corner)]);
        }
        std::sort(used.begin(), used.end());
        report_.components = static_cast<int>(std::unique(used.begin(), used.end()) - used.begin());
        if (report_.components > 1) {
            warn(fmt::format("{} connected components", report_.components));
        }
    }

    void count_isolated_vertices() {
        std::vector<char> in_face(at(rings_.vertex_count()), 0);
        for (const Face& face : faces_) {
            for (const int corner : face) in_face[at(corner)] = 1;
        }
        report_.isolated_vertices = static_cast<int>(std::ranges::count(in_face, 0));
        if (report_.isolated_vertices == 0) return;
        const auto first = std::ranges::find(in_face, 0) - in_face.begin();
        warn(counted(report_.isolated_vertices, "vertex is", "vertices are") +
             fmt::format(" in no face, the first is vertex {}", first + 1));
    }

    void warn(std::string text) { report_.warnings.push_back(std::move(text)); }

    const std::vector<Face>& faces_;   // of the file
    const std::vector<Face>& joined_;  // of the surface
    const std::vector<int>& numbers_;
    const SurfaceMesh& mesh_;
    const OneRings& rings_;
    ConnectivityReport report_;
};

}  // namespace

ConnectivityReport report_connectivity(const std::vector<Face>& faces,
                                       const std::vector<Face>& joined,
                                       const std::vector<int>& face_numbers,
                                       const SurfaceMesh& mesh) {
    return ReportBuilder(faces, joined, face_numbers, mesh).build();
}

}  // namespace mscomp

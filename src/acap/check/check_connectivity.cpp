// SPDX-License-Identifier: MIT
// Places of what analyze_connectivity counts.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "check_findings.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

/// Sets of vertices that grow together.
class Groups {
  public:
    int find(int x) {
        const auto [place, fresh] = parent_.try_emplace(x, x);
        return fresh || place->second == x ? x : place->second = find(place->second);
    }
    void join(int x, int y) {
        const int a = find(x), b = find(y);
        parent_[std::max(a, b)] = std::min(a, b);
    }
    /// Members of every group, by its lowest vertex.
    std::map<int, int> sizes() {
        std::map<int, int> result;
        for (const auto& [x, parent] : parent_) ++result[find(parent)];
        return result;
    }

  private:
    std::map<int, int> parent_;
};

class ConnectivityFinder {
  public:
    ConnectivityFinder(int vertex_count, const std::vector<Face>& faces,
                       const std::vector<int>& face_numbers, const VertexPlaces& places,
                       std::string path)
        : faces_(faces),
          joined_(places.joined(faces)),
          places_(places),
          numbers_(face_numbers),
          path_(std::move(path)) {
        const SurfaceConnectivity surface =
            analyze_connectivity(vertex_count, faces, face_numbers, places);
        rings_ = surface.rings;
        report_ = surface.report;
        for (const Face& face : joined_) {
            if (is_degenerate(face)) continue;
            for (std::size_t k = 0; k < 3; ++k) {
                const int a = face[k], b = face[(k + 1) % 3];
                Sides& sides = edges_[std::minmax(a, b)];
                (a < b ? sides.upwards : sides.downwards) += 1;
            }
        }
    }

    void find(std::vector<Finding>& findings) {
        find_edges(findings);
        find_touching_fans(findings);
        find_odd_faces(findings);
        find_isolated_vertices(findings);
        find_components(findings);
        find_boundary(findings);
    }

    const ConnectivityReport& report() const { return report_; }

  private:
    struct Sides {
        int upwards = 0, downwards = 0;
    };

    CheckPlace vertex_place(int vertex, std::string text) const {
        CheckPlace place{.text = std::move(text), .file = path_};
        place.vertex = vertex + 1;
        return place;
    }

    void find_edges(std::vector<Finding>& findings) const {
        FindingBuilder crowded(Severity::warning, "non_manifold_edges");
        FindingBuilder flipped(Severity::warning, "misoriented_edges");
        for (const auto& [ends, sides] : edges_) {
            const int faces = sides.upwards + sides.downwards;
            if (faces < 2 || (sides.upwards == 1 && sides.downwards == 1)) continue;
            std::string text =
                fmt::format("between the vertices {} and {}", ends.first + 1, ends.second + 1);
            if (faces > 2) text += fmt::format(": {} faces", faces);
            CheckPlace place = vertex_place(ends.first, std::move(text));
            place.other_vertex = ends.second + 1;
            place.count = faces;
            (faces > 2 ? crowded : flipped).add(std::move(place));
        }
        crowded.finish(counted(crowded.count(), "edge has", "edges have") + " more than two faces",
                       "Extraction works: all faces count. The surface is not a clean one there; "
                       "repair the mesh if you can.",
                       findings);
        flipped.finish(counted(flipped.count(), "edge lies", "edges lie") +
                           " between two faces of opposite orientation",
                       "Extraction works, but normals cancel there. Make the orientation of the "
                       "faces consistent in all files if you can.",
                       findings);
    }

    /// The faces around a vertex form one fan exactly if their far edges hang together.
    void find_touching_fans(std::vector<Finding>& findings) const {
        FindingBuilder builder(Severity::warning, "non_manifold_vertices");
        if (report_.non_manifold_vertices > 0) {
            std::map<int, Groups> far_edges;
            for (const Face& face : joined_) {
                if (is_degenerate(face)) continue;
                for (std::size_t k = 0; k < 3; ++k) {
                    far_edges[face[k]].join(face[(k + 1) % 3], face[(k + 2) % 3]);
                }
            }
            for (auto& [vertex, fans] : far_edges) {
                const std::size_t count = fans.sizes().size();
                if (count < 2) continue;
                builder.add(
                    vertex_place(vertex, fmt::format("vertex {}: {} pieces", vertex + 1, count)));
            }
        }
        builder.finish(counted(builder.count(), "vertex joins", "vertices join") +
                           " pieces of surface that touch only there",
                       "Extraction works. Split such a vertex in all files if the pieces should "
                       "move freely.",
                       findings);
    }

    void find_odd_faces(std::vector<Finding>& findings) const {
        FindingBuilder twice(Severity::warning, "duplicate_faces");
        FindingBuilder degenerate(Severity::warning, "degenerate_faces");
        std::map<Face, int> first_with;
        int last_degenerate = 0, last_twice = 0;  // triangles of one polygon are neighbours
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            const int number = numbers_[f];
            Face sorted = faces_[f];
            std::sort(sorted.begin(), sorted.end());
            const int first = first_with.try_emplace(sorted, number).first->second;
            CheckPlace place{.text = fmt::format("face {}", number), .file = path_};
            place.face = number;
            if (is_degenerate(faces_[f]) && std::exchange(last_degenerate, number) != number) {
                degenerate.add(place);
            }
            if (first == number || std::exchange(last_twice, number) == number) continue;
            place.text += fmt::format(", as face {}", first);
            twice.add(std::move(place));
        }
        twice.finish(
            counted(twice.count(), "face has", "faces have") + " the vertices of an earlier one",
            "Extraction works. Remove one of each pair in all files if you can.", findings);
        degenerate.finish(counted(degenerate.count(), "face has", "faces have") + " a vertex twice",
                          "Such faces carry no surface and are passed over.", findings);
    }

    void find_isolated_vertices(std::vector<Finding>& findings) const {
        std::vector<char> in_face(at(rings_.vertex_count()), 0);
        for (const Face& face : faces_) {
            for (const int corner : face) in_face[at(corner)] = 1;
        }
        FindingBuilder builder(Severity::warning, "isolated_vertices");
        for (int i = 0; i < rings_.vertex_count(); ++i) {
            if (in_face[at(i)] != 0) continue;
            builder.add(vertex_place(i, fmt::format("vertex {}", i + 1)));
        }
        builder.finish(
            counted(builder.count(), "vertex is", "vertices are") + " in no face",
            "They get no deformation, have no part in alignment, scale and measures, and "
            "stay where the reference has them in what is learnt. Remove them from all "
            "files if they are leftovers.",
            findings);
    }

    void find_components(std::vector<Finding>& findings) const {
        if (report_.components < 2) return;
        const std::vector<int> component = connected_components(rings_);
        std::map<int, std::pair<int, int>> first_and_size;
        for (int i = 0; i < rings_.vertex_count(); ++i) {
            const int place = places_.place(i);
            if (place < 0 || rings_.degree(places_.vertex(place)) == 0) continue;
            const int piece = component[at(places_.vertex(place))];
            auto& [first, size] = first_and_size.try_emplace(piece, i, 0).first->second;
            ++size;
        }
        FindingBuilder builder(Severity::warning, "several_components");
        for (const auto& [number, piece] : first_and_size) {
            CheckPlace place =
                vertex_place(piece.first, fmt::format("{} from vertex {} on",
                                                      counted(piece.second, "vertex", "vertices"),
                                                      piece.first + 1));
            place.count = piece.second;
            builder.add(std::move(place));
        }
        builder.finish(
            fmt::format("the mesh is in {} pieces that do not hang together", builder.count()),
            "Features describe how a surface bends, not where a piece floats: what is "
            "learnt says nothing about how the pieces lie to each other.",
            findings);
    }

    void find_boundary(std::vector<Finding>& findings) const {
        Groups loops;
        std::map<int, int> edges;
        for (const auto& [ends, sides] : edges_) {
            if (sides.upwards + sides.downwards == 1) loops.join(ends.first, ends.second);
        }
        for (const auto& [ends, sides] : edges_) {
            if (sides.upwards + sides.downwards == 1) ++edges[loops.find(ends.first)];
        }
        FindingBuilder builder(Severity::note, "boundary");
        for (const auto& [first, count] : edges) {
            CheckPlace place = vertex_place(
                first,
                fmt::format("{} from vertex {} on", counted(count, "edge", "edges"), first + 1));
            place.count = count;
            builder.add(std::move(place));
        }
        builder.finish("the surface is open: " + counted(builder.count(), "boundary", "boundaries"),
                       "Nothing is to be done if the mesh is meant to have holes.", findings);
    }

    const std::vector<Face>& faces_;  // of the file
    std::vector<Face> joined_;        // of the surface
    const VertexPlaces& places_;
    const std::vector<int>& numbers_;
    std::string path_;
    OneRings rings_;
    ConnectivityReport report_;
    std::map<std::pair<int, int>, Sides> edges_;
};

}  // namespace

void find_connectivity(int vertex_count, const std::vector<Face>& faces,
                       const std::vector<int>& face_numbers, const VertexPlaces& places,
                       CheckReport& report, std::vector<Finding>& findings) {
    ConnectivityFinder finder(vertex_count, faces, face_numbers, places, report.reference);
    finder.find(findings);
    report.edges = static_cast<int>(one_rings_of_faces(vertex_count, faces).neighbors.size() / 2);
    report.components = finder.report().components;
    report.boundary_loops = finder.report().boundary_loops;
}

void find_coincident(const std::vector<int>& lowest, const std::string& path,
                     std::vector<Finding>& findings) {
    FindingBuilder builder(Severity::note, "coincident_vertices");
    for (std::size_t v = 0; v < lowest.size(); ++v) {
        const int other = lowest[v];
        if (at(other) == v) continue;
        const int vertex = static_cast<int>(v) + 1;
        builder.add({.text = fmt::format("vertex {} lies on {}", vertex, other + 1),
                     .file = path,
                     .vertex = vertex,
                     .other_vertex = other + 1});
    }
    builder.finish(
        counted(builder.count(), "vertex lies", "vertices lie") + " on another one in every shape",
        "As along a UV seam or in a triangle soup. They are one place of the surface: "
        "what is learnt moves them together, and files keep them apart.",
        findings);
}

}  // namespace mscomp

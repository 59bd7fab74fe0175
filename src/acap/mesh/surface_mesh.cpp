// SPDX-License-Identifier: MIT
#include "mscomp/acap/mesh/surface_mesh.h"

#include <fmt/format.h>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <mutex>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

struct HalfEdgeTraits : OpenMesh::DefaultTraits {
    VertexAttributes(OpenMesh::Attributes::None);
    FaceAttributes(OpenMesh::Attributes::None);
    HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge);
};
using HalfEdgeMesh = OpenMesh::TriMesh_ArrayKernelT<HalfEdgeTraits>;
using Edge = std::array<int, 2>;

/// OpenMesh reports every refused face on a stream of its own, one for the whole process; we count
/// and report them ourselves.
class QuietOpenMesh {
  public:
    QuietOpenMesh() : lock_(mutex()), was_enabled_(::omerr().is_enabled()) { ::omerr().disable(); }
    QuietOpenMesh(const QuietOpenMesh&) = delete;
    QuietOpenMesh& operator=(const QuietOpenMesh&) = delete;
    ~QuietOpenMesh() {
        if (was_enabled_) ::omerr().enable();
    }

  private:
    static std::mutex& mutex() {
        static std::mutex one;
        return one;
    }

    std::lock_guard<std::mutex> lock_;
    bool was_enabled_;
};

Edge edge_between(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

void check_range(int vertex_count, const std::vector<Face>& faces) {
    for (std::size_t i = 0; i < faces.size(); ++i) {
        for (const int corner : faces[i]) {
            if (corner >= 0 && corner < vertex_count) continue;
            throw MeshError(fmt::format("face {} refers to vertex {}, the mesh has 0 to {}", i,
                                        corner, vertex_count - 1));
        }
    }
}

/// The compressed rows of a list per vertex, each sorted and without repetitions.
class Rows {
  public:
    explicit Rows(std::vector<int>& offsets, std::vector<int>& entries)
        : offsets_(offsets), entries_(entries) {
        offsets_.assign(1, 0);
    }
    std::vector<int>& row() { return row_; }
    void finish_row() {
        std::sort(row_.begin(), row_.end());
        row_.erase(std::unique(row_.begin(), row_.end()), row_.end());
        entries_.insert(entries_.end(), row_.begin(), row_.end());
        offsets_.push_back(static_cast<int>(entries_.size()));
        row_.clear();
    }

  private:
    std::vector<int>& offsets_;
    std::vector<int>& entries_;
    std::vector<int> row_;
};

}  // namespace

struct SurfaceMesh::HalfEdges {
    HalfEdgeMesh mesh;
    std::vector<int> face;  // of every OpenMesh face the number that the arrays gave it

    OpenMesh::VertexHandle vertex(int i) const {
        return mesh.vertex_handle(static_cast<unsigned>(i));
    }
    /// Adds the face if that leaves the mesh manifold. Two fans that touch at a vertex do: going
    /// around it OpenMesh passes from one to the other over their boundaries.
    bool add(int number, const Face& corners) {
        if (is_degenerate(corners)) return false;
        const auto added =
            mesh.add_face(vertex(corners[0]), vertex(corners[1]), vertex(corners[2]));
        if (!added.is_valid()) return false;
        face.push_back(number);
        return true;
    }
};

SurfaceMesh::SurfaceMesh(int vertex_count, const std::vector<Face>& faces) {
    check_range(vertex_count, faces);
    auto half_edges = std::make_unique<HalfEdges>();
    HalfEdgeMesh& mesh = half_edges->mesh;
    mesh.reserve(at(vertex_count), faces.size() * 3 / 2, faces.size());
    for (int i = 0; i < vertex_count; ++i) mesh.new_vertex();
    {
        const QuietOpenMesh quiet;
        for (std::size_t f = 0; f < faces.size(); ++f) {
            if (half_edges->add(static_cast<int>(f), faces[f])) continue;
            beside_.push_back(static_cast<int>(f));
            faces_beside_.push_back(faces[f]);
        }
    }
    const OneRings rings_beside = one_rings_of_faces(vertex_count, faces_beside_);
    std::vector<std::vector<int>> around_beside(beside_.empty() ? 0 : at(vertex_count));
    for (std::size_t n = 0; n < beside_.size(); ++n) {
        for (const int corner : faces_beside_[n]) around_beside[at(corner)].push_back(beside_[n]);
    }
    Rows rings(rings_.offsets, rings_.neighbors),
        around(faces_around_.offsets, faces_around_.faces);
    for (int i = 0; i < vertex_count; ++i) {
        const auto begin = rings_beside.neighbors.begin();
        rings.row().assign(begin + rings_beside.offsets[at(i)],
                           begin + rings_beside.offsets[at(i) + 1]);
        if (!beside_.empty()) around.row() = around_beside[at(i)];
        const auto vertex = half_edges->vertex(i);
        for (const auto neighbor : mesh.vv_range(vertex)) rings.row().push_back(neighbor.idx());
        for (const auto face : mesh.vf_range(vertex)) {
            around.row().push_back(half_edges->face[at(face.idx())]);
        }
        rings.finish_row();
        around.finish_row();
    }
    half_edges_ = std::move(half_edges);
}

SurfaceMesh::SurfaceMesh(SurfaceMesh&&) noexcept = default;
SurfaceMesh& SurfaceMesh::operator=(SurfaceMesh&&) noexcept = default;
SurfaceMesh::~SurfaceMesh() = default;

std::vector<std::array<int, 2>> SurfaceMesh::boundary_edges() const {
    // Edges of faces beside, once for every face that has them.
    std::vector<Edge> beside;
    for (const Face& face : faces_beside_) {
        if (is_degenerate(face)) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            beside.push_back(edge_between(face[k], face[(k + 1) % 3]));
        }
    }
    std::sort(beside.begin(), beside.end());
    const HalfEdgeMesh& mesh = half_edges_->mesh;
    std::vector<Edge> result;
    for (const auto edge : mesh.edges()) {
        const Edge ends = edge_between(edge.v0().idx(), edge.v1().idx());
        if (edge.is_boundary() && !std::binary_search(beside.begin(), beside.end(), ends)) {
            result.push_back(ends);
        }
    }
    for (auto first = beside.begin(); first != beside.end();) {
        const auto last = std::upper_bound(first, beside.end(), *first);
        const auto [a, b] = *first;
        const bool is_held =
            mesh.find_halfedge(half_edges_->vertex(a), half_edges_->vertex(b)).is_valid();
        if (last - first == 1 && !is_held) result.push_back(*first);
        first = last;
    }
    std::sort(result.begin(), result.end());
    return result;
}

}  // namespace mscomp

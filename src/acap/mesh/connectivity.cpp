// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <algorithm>
#include <stdexcept>

#include "connectivity_report.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

struct HalfEdgeTraits : OpenMesh::DefaultTraits {
    VertexAttributes(OpenMesh::Attributes::None);
    FaceAttributes(OpenMesh::Attributes::None);
    HalfedgeAttributes(OpenMesh::Attributes::PrevHalfedge);
};
using HalfEdgeMesh = OpenMesh::TriMesh_ArrayKernelT<HalfEdgeTraits>;

/// OpenMesh reports every refused face on a stream of its own; we count and report them ourselves.
class QuietOpenMesh {
  public:
    QuietOpenMesh() : was_enabled_(::omerr().is_enabled()) { ::omerr().disable(); }
    QuietOpenMesh(const QuietOpenMesh&) = delete;
    QuietOpenMesh& operator=(const QuietOpenMesh&) = delete;
    ~QuietOpenMesh() {
        if (was_enabled_) ::omerr().enable();
    }

  private:
    bool was_enabled_;
};

void check_range(int vertex_count, const std::vector<Face>& faces) {
    for (std::size_t i = 0; i < faces.size(); ++i) {
        for (const int corner : faces[i]) {
            if (corner >= 0 && corner < vertex_count) continue;
            throw MeshError(fmt::format("face {} refers to vertex {}, the mesh has 0 to {}", i,
                                        corner, vertex_count - 1));
        }
    }
}

/// Adds what fits a manifold to `mesh` and returns the faces that do not.
std::vector<Face> add_faces(int vertex_count, const std::vector<Face>& faces, HalfEdgeMesh& mesh) {
    const QuietOpenMesh quiet;
    mesh.reserve(at(vertex_count), faces.size() * 3 / 2, faces.size());
    for (int i = 0; i < vertex_count; ++i) mesh.new_vertex();
    std::vector<Face> refused;
    for (const Face& face : faces) {
        const bool added = !is_degenerate(face) &&
                           mesh.add_face(mesh.vertex_handle(static_cast<unsigned>(face[0])),
                                         mesh.vertex_handle(static_cast<unsigned>(face[1])),
                                         mesh.vertex_handle(static_cast<unsigned>(face[2])))
                               .is_valid();
        if (!added) refused.push_back(face);
    }
    return refused;
}

OneRings rings_of(const HalfEdgeMesh& mesh, const OneRings& beside) {
    OneRings rings;
    std::vector<int> ring;
    for (int i = 0; i < beside.vertex_count(); ++i) {
        const auto begin = beside.neighbors.begin();
        ring.assign(begin + beside.offsets[at(i)], begin + beside.offsets[at(i) + 1]);
        for (const auto neighbor : mesh.vv_range(mesh.vertex_handle(static_cast<unsigned>(i)))) {
            ring.push_back(neighbor.idx());
        }
        std::sort(ring.begin(), ring.end());
        ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
        rings.neighbors.insert(rings.neighbors.end(), ring.begin(), ring.end());
        rings.offsets.push_back(static_cast<int>(rings.neighbors.size()));
    }
    return rings;
}

}  // namespace

SurfaceConnectivity analyze_connectivity(int vertex_count, const std::vector<Face>& faces) {
    check_range(vertex_count, faces);
    HalfEdgeMesh mesh;
    const std::vector<Face> refused = add_faces(vertex_count, faces, mesh);
    SurfaceConnectivity surface;
    surface.rings = rings_of(mesh, one_rings_of_faces(vertex_count, refused));
    surface.report = report_connectivity(faces, surface.rings);
    surface.report.faces_beside = static_cast<int>(refused.size());
    return surface;
}

}  // namespace mscomp

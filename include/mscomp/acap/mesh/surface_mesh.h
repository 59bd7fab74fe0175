// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "mscomp/base/index.h"
#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Faces around every vertex as compressed rows: those of i are faces[offsets[i] .. offsets[i+1]),
/// ascending.
struct VertexFaces {
    std::vector<int> offsets{0};
    std::vector<int> faces;

    int count(int vertex) const { return offsets[at(vertex) + 1] - offsets[at(vertex)]; }
};

/// The connectivity of a validated mesh as an OpenMesh mesh: what is manifold as half-edges, the
/// faces that would make it something else (degenerate, repeated, turned over, a third one at an
/// edge) beside it. What is asked of it holds for all faces, those beside it included. Positions
/// are not kept: N shapes share one connectivity.
class SurfaceMesh {
  public:
    /// Throws MeshError if a face refers to a vertex outside 0 .. V-1.
    SurfaceMesh(int vertex_count, const std::vector<Face>& faces);
    explicit SurfaceMesh(const TriangleMesh& mesh) : SurfaceMesh(mesh.vertex_count(), mesh.faces) {}
    SurfaceMesh(SurfaceMesh&&) noexcept;
    SurfaceMesh& operator=(SurfaceMesh&&) noexcept;
    ~SurfaceMesh();

    int vertex_count() const { return rings_.vertex_count(); }
    /// Ends of every edge, going around the vertices: equal to one_rings_of_faces.
    const OneRings& rings() const { return rings_; }
    /// A face that has a vertex twice is around it once.
    const VertexFaces& faces_around() const { return faces_around_; }
    /// Faces that are kept beside the half-edges, ascending.
    const std::vector<int>& faces_beside() const { return beside_; }
    /// Edges of exactly one face, lower vertex first, ascending; degenerate faces do not count.
    std::vector<std::array<int, 2>> boundary_edges() const;
    /// Connected component of every vertex, numbered from 0 in the order of their lowest vertex.
    std::vector<int> components() const { return connected_components(rings_); }

  private:
    struct HalfEdges;

    std::unique_ptr<const HalfEdges> half_edges_;
    std::vector<Face> faces_beside_;  // corners of `beside_`
    std::vector<int> beside_;
    OneRings rings_;
    VertexFaces faces_around_;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "connectivity_report.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/acap/mesh/surface_mesh.h"

namespace mscomp {

SurfaceConnectivity analyze_connectivity(int vertex_count, const std::vector<Face>& faces,
                                         const std::vector<int>& face_numbers,
                                         const VertexPlaces& places) {
    if (places.are_all_vertices()) {
        const SurfaceMesh mesh(vertex_count, faces);
        return {mesh.rings(), report_connectivity(faces, faces, face_numbers, mesh)};
    }
    const std::vector<Face> joined = places.joined(faces);
    const SurfaceMesh mesh(vertex_count, joined);
    return {mesh.rings(), report_connectivity(faces, joined, face_numbers, mesh)};
}

}  // namespace mscomp

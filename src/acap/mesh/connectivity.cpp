// SPDX-License-Identifier: MIT
#include "connectivity_report.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/acap/mesh/surface_mesh.h"

namespace mscomp {

SurfaceConnectivity analyze_connectivity(int vertex_count, const std::vector<Face>& faces,
                                         const std::vector<int>& face_numbers) {
    const SurfaceMesh mesh(vertex_count, faces);
    return {mesh.rings(), report_connectivity(faces, face_numbers, mesh)};
}

}  // namespace mscomp

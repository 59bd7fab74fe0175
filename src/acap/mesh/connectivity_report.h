// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/acap/mesh/surface_mesh.h"

namespace mscomp {

/// Counts what is odd about `faces` as the file has them, and about those joined at places, of
/// which `mesh` was made; for `face_numbers` see analyze_connectivity.
ConnectivityReport report_connectivity(const std::vector<Face>& faces,
                                       const std::vector<Face>& joined,
                                       const std::vector<int>& face_numbers,
                                       const SurfaceMesh& mesh);

}  // namespace mscomp

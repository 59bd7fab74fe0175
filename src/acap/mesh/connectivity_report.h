// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/acap/mesh/mesh_sequence.h"

namespace mscomp {

/// Counts what is odd about `faces`; `rings` are those of all their edges. Leaves faces_beside 0.
ConnectivityReport report_connectivity(const std::vector<Face>& faces, const OneRings& rings);

}  // namespace mscomp

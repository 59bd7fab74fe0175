// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// How edges count, by angles of the reference (method §1).
enum class EdgeWeights { cotangent, authors, uniform };
EdgeWeights parse_edge_weights(const std::string& name);  // throws UsageError
std::string to_string(EdgeWeights weights);

/// c_ij of the reference beside the neighbours of one_rings_of_faces, c_ij = c_ji > 0 (method §1).
std::vector<double> ring_weights(const TriangleMesh& reference, EdgeWeights weights);

}  // namespace mscomp

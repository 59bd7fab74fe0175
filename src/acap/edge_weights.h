// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mscomp/acap/extract.h"
#include "mscomp/base/mesh_data.h"
#include "occurrences.h"

namespace mscomp {

using ConstPoint = Eigen::Map<const Eigen::Vector3d>;
inline ConstPoint as_vector(const Point& point) { return ConstPoint(point.data()); }

/// Unit normal of a triangle, none if its area vanishes beside its longest edge squared.
std::optional<Eigen::Vector3d> face_normal(const std::vector<Point>& points, const Face& face);

struct EdgeWeightTable {
    std::vector<double> weights;  // c_ij beside rings.neighbors; c_ij = c_ji > 0
    Occurrences zero_area_faces;  // contribute nothing
};

/// Weights of the reference (method §1): cotangent max(½(cot α + cot β), 1e-3), authors
/// sqrt(g(½(cot α + cot β))) with g(x) = 1 + x for x > 0 and e^x otherwise, uniform 1. A boundary
/// edge has one cotangent, a non-manifold edge the sum of all. Independent of the mesh's scale.
EdgeWeightTable edge_weights(const TriangleMesh& reference, const OneRings& rings,
                             EdgeWeights kind);

}  // namespace mscomp

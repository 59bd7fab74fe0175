// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "mscomp/acap/edge_weights.h"
#include "mscomp/base/index.h"
#include "mscomp/base/mesh_data.h"
#include "occurrences.h"

namespace mscomp {

using ConstPoint = Eigen::Map<const Eigen::Vector3d>;
inline ConstPoint as_vector(const Point& point) { return ConstPoint(point.data()); }

/// Doubled area over squared longest edge at or below which a face has no normal.
inline constexpr double kZeroArea = 1e-12;

/// The normal of the triangle with edges `ab` and `ac`, the longest of its edges `length`.
std::optional<Eigen::Vector3d> face_normal_of_any_size(const Eigen::Vector3d& ab,
                                                       const Eigen::Vector3d& ac, double length);

/// Unit normal of a triangle, none if its area vanishes beside its longest edge squared.
inline std::optional<Eigen::Vector3d> face_normal(const std::vector<Point>& points,
                                                  const Face& face) {
    const auto a = as_vector(points[at(face[0])]);
    const Eigen::Vector3d ab = as_vector(points[at(face[1])]) - a;
    const Eigen::Vector3d ac = as_vector(points[at(face[2])]) - a;
    const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
    // Where squares of areas stay well inside the range of double, one root is enough.
    if (!(longest > 1e-60 && longest < 1e60)) {
        return face_normal_of_any_size(ab, ac, std::sqrt(longest));
    }
    const Eigen::Vector3d cross = ab.cross(ac);
    const double square = cross.squaredNorm();
    if (!(square > kZeroArea * kZeroArea * longest * longest)) return std::nullopt;
    return cross * (1 / std::sqrt(square));
}

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

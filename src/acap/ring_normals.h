// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "edge_weights.h"
#include "mscomp/acap/mesh/surface_mesh.h"

namespace mscomp {

inline constexpr double kHeightFactor = 0.3;

/// The pseudo-edge of every vertex: direction and length (method §1, deformation gradient).
struct RingNormals {
    std::vector<Eigen::Vector3d> normal;  // (V) unit; zero at isolated vertices
    std::vector<double> sum_length;       // (V) length of the sum of the unit face normals
    std::vector<double> height;           // (V) kHeightFactor x mean edge length of the ring
    std::vector<char> folded;             // (V) face normals cancel: the sign of `normal` is free
    Occurrences zero_area_faces;          // by face
    Occurrences folded_rings;             // by vertex
};

/// Normalised sums of the unit normals of the faces around every vertex; where they cancel, the
/// direction in which the ring spreads least.
RingNormals ring_normals(const std::vector<Point>& points, const std::vector<Face>& faces,
                         const VertexFaces& around, const OneRings& rings);

/// The same without the heights, which stay empty, for who goes around the rings anyway.
RingNormals ring_directions(const std::vector<Point>& points, const std::vector<Face>& faces,
                            const VertexFaces& around, const OneRings& rings);

}  // namespace mscomp

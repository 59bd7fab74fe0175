// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

inline constexpr double kLimbLength = 12;  // from shoulder to finger tips

/// One ring of vertices around the axis.
struct Ring {
    double height = 0;
    int first = 0, count = 0;  // its vertices
};

/// The limb that `generate arm` bends, at rest: straight up along z, the front of the elbow at -y,
/// the hand's width along y. A closed manifold of nearly equilateral triangles.
struct Limb {
    TriangleMesh mesh;          // at rest
    std::vector<Ring> rings;    // both poles are rings of one vertex
    std::vector<int> ring_of;   // (V)
    std::vector<double> angle;  // (V) around the axis, 0 at +x, pi/2 at +y
    std::vector<Eigen::Vector3d> normal;
};

/// The coarsest limb with at least `vertices` vertices.
Limb limb_with_vertices(int vertices);

/// (V) unit normals, faces weighted by their area.
std::vector<Eigen::Vector3d> vertex_normals(const TriangleMesh& mesh);

/// Rises smoothly from 0 at `from` to 1 at `to`.
double smooth_step(double s, double from, double to);

}  // namespace mscomp

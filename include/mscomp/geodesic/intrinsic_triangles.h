// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// One triangle known by its edge lengths only and laid flat: its corners stand at (0,0), (base,0)
/// and (x,y) with base > 0 the longest edge, 0 <= x <= base and y > 0.
struct FlatTriangle {
    Face corners{};
    double base = 0, x = 0, y = 0;

    double area() const { return 0.5 * base * y; }
    /// Cotangents of the angles at the three corners.
    std::array<double, 3> cotangents() const {
        return {x / y, (base - x) / y, (x * x - base * x + y * y) / (base * y)};
    }
};

/// The surface as a heap of flat triangles, lengths in units of the mean edge length, so that
/// nothing computed from it depends on the unit of the mesh.
///
/// Faces with a vertex twice are left out. Where two edges of a face together do not exceed the
/// third by 1e-5 (zero area, coinciding vertices), one small length of about that size is added to
/// *all* edges of the mesh (intrinsic mollification, Sharp and Crane 2020), after which every
/// triangle has an area; a sound mesh is not changed. Then edges are flipped within the surface
/// until it is intrinsically Delaunay (Bobenko and Springborn 2007): the surface is the same in
/// every point, but no cotangent weight is negative any more, so that heat stays positive on the
/// obtuse triangles of scans. Only edges that are not manifold, or join triangles of opposite
/// orientation, may keep a negative weight.
struct IntrinsicTriangles {
    int vertex_count = 0;
    double mean_edge_length = 0;          // in mesh units; 0 if there is no edge of positive length
    double added_length = 0;              // what mollification added, in mean edge lengths
    long flips = 0;                       // edges flipped to become Delaunay
    std::vector<FlatTriangle> triangles;  // empty if mean_edge_length is 0
    std::vector<int> component;           // (V) connected component by the faces that count
};

/// Throws MeshError if a coordinate is not finite or a face refers to a vertex that is not there.
IntrinsicTriangles intrinsic_triangles(const TriangleMesh& mesh);

/// (V) L x with the cotangent Laplacian: (L x)_i = sum_j c_ij (x_i - x_j), c_ij half the cotangents
/// opposite edge ij. Positive semidefinite; 0 for constants.
std::vector<double> apply_laplacian(const IntrinsicTriangles& surface, std::span<const double> x);

/// (V) a third of the area of the triangles around each vertex, in squared mean edge lengths.
std::vector<double> lumped_mass(const IntrinsicTriangles& surface);

}  // namespace mscomp

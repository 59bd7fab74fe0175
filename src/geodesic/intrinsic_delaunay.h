// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// A triangle by its edge lengths; lengths[k] joins corners k and k + 1.
struct EdgeLengths {
    Face corners{};
    std::array<double, 3> lengths{};
};

/// Area by Heron's formula in an order that keeps all digits of needle-shaped triangles (Kahan).
double area_of(const std::array<double, 3>& lengths);

/// Flips edges between two equally oriented triangles, inside the surface and without moving a
/// vertex, until the two angles opposite each of them sum to at most pi. The surface stays the same
/// in every point; its cotangent weights become >= 0. Two vertices may be joined by several edges
/// afterwards, and a triangle may have a corner twice. Edges of one triangle, of more than two, or
/// of two with opposite orientation stay as they are. Returns the number of flips.
long make_intrinsic_delaunay(std::vector<EdgeLengths>& triangles);

}  // namespace mscomp

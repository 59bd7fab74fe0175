// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/render/render.h"

namespace mscomp {

/// A result beside its truth, as they are drawn: the result already aligned with the truth.
struct ComparedShape {
    std::string name;              // below the truth
    std::string remark;            // below the result, such as its error
    std::vector<Point> truth;      // (V)
    std::vector<Point> result;     // (V)
    std::vector<double> distance;  // (V) of vertices, in mesh units: the colour of the result
};

/// A contact sheet of results, in the order given: each truth in white and, right of it, its result
/// from white (no distance) to blue (`largest_distance` of all shapes, printed in the heading). One
/// view for all, which suits `reference`, wide enough for every shape. A result that has vertices
/// which are not finite is an empty picture that says so; a distance that is not finite counts as
/// 0. `longer_side` is that of one picture, `columns` how many pairs stand beside each other.
/// Throws UsageError (no shapes, sizes that differ, no columns) or MeshError as render_mesh.
Image error_sheet(const TriangleMesh& reference, std::span<const ComparedShape> shapes,
                  const std::string& title, int longer_side = 340, int columns = 3);

/// The distance drawn in full blue: the largest finite one, 0 if there is none above 0.
double largest_distance(std::span<const ComparedShape> shapes);

}  // namespace mscomp

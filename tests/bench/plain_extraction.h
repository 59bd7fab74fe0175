// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace mscomp::plain {

/// ACAP features of OBJ files of one connectivity relative to the first, as one writes it down
/// first: one thread, double, one loop per sentence of the method, nothing kept between shapes but
/// what the reference alone decides. What extraction is compared with and measured against; it
/// shares no code with it.
///
/// Rows of 9 float32 per vertex (r, then S11 S12 S13 S22 S23 S33) go to `output`, shape by shape,
/// without a header. Propagation along the mesh, breadth first from vertex 0 of a component, makes
/// the logarithms consistent. Wants a triangle mesh without faces that have no area and without
/// rings whose normals cancel.
/// \return per shape Σ_edges |r_i - r_j|²
std::vector<double> extract(const std::vector<std::string>& paths, const std::string& output);

}  // namespace mscomp::plain

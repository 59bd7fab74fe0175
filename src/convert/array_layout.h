// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/convert/npy.h"

namespace mscomp {

/// What is known of the number of vertices before an array is looked at.
struct VertexCount {
    std::int64_t least = 1;   // one more than the largest corner of a face
    std::int64_t exact = -1;  // of the reference, or unknown
    bool allows(std::int64_t count) const { return exact >= 0 ? count == exact : count >= least; }
};

/// Whether `array` can be read as `width` numbers for each vertex of each shape.
bool has_vertex_rows(const NpyArray& array, std::int64_t width, const VertexCount& vertices);

/// `array` as (N,V,width), a view. Where (N,V,width) itself does not fit `vertices`, the only one
/// of (V,width,N), (N,width,V), (width,V,N), (V,width), (width,V), (N,V*width) and (V*width,N) that
/// does; what was taken is added to `notes`. Throws InputError if there is none, or several.
NpyArray vertex_rows(const NpyArray& array, std::int64_t width, const VertexCount& vertices,
                     std::vector<std::string>& notes);

/// Corners (F*3) of faces (F,3) or (3,F), as they count. Throws InputError.
std::vector<int> face_corners(const NpyArray& array);

/// Lets corners count from 0 that can only count from 1: none is 0, and one is V. Adds a note.
void count_from_zero(std::vector<int>& corners, int vertex_count, std::vector<std::string>& notes);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/base/safetensors.h"

namespace mscomp {

/// Throws InputError unless `shape` is `wanted`, where -1 accepts any length.
void require_shape(const Shape& shape, const Shape& wanted, const std::string& path);

/// Throws InputError unless there are 1 to 2^31 - 1 of both.
void require_counts(std::int64_t shapes, std::int64_t vertices, const std::string& path);

/// `corners` (F·3) as faces. Throws InputError if there is none or one is not in 0 .. V-1.
std::vector<Face> checked_faces(const std::vector<int>& corners, int vertex_count,
                                const std::string& path);

/// Numbers in groups of three.
std::vector<Point> points_of(const std::vector<double>& numbers);

}  // namespace mscomp

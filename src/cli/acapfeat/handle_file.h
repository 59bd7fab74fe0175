// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "mscomp/acap/reconstruct.h"

namespace mscomp {

/// Reads {"handles": [{"vertex": 12, "position": [x, y, z], "weight": 10}, ...]}; vertices count
/// from 0, and without a weight a handle is met exactly. Throws IoError, or InputError naming the
/// handle, what it has and what is wanted.
std::vector<Handle> read_handles(const std::string& path, int vertex_count);

}  // namespace mscomp

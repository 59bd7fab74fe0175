// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

#include "mscomp/base/safetensors.h"
#include "mscomp/model/stored_arrays.h"
#include "nn/parameter_set.h"
#include "nn/vertex_order.h"

namespace mscomp::nn {

/// Adds an array like a parameter with `extents`, brought from inner to user order when it is
/// written; what that takes is the memory of one component. Borrows `inner` and `order` until then.
void add_inner(StoredArrays& arrays, const std::string& name, const Extents& extents,
               std::span<const float> inner, const VertexOrder& order);

/// Fills an array like a parameter with `extents` from a file. What is right already is not
/// written, so that zeros that take up no memory stay so. Throws InputError.
void read_inner(const SafetensorsFile& file, const std::string& name, const Extents& extents,
                const VertexOrder& order, std::span<float> inner);

}  // namespace mscomp::nn

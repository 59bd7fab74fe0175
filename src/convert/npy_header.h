// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "mscomp/base/safetensors.h"

namespace mscomp {

/// What the dictionary in front of a numpy array says.
struct NpyHeader {
    std::string descr;  // such as "<f8"
    bool fortran_order = false;
    Shape shape;
};

/// Parses "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }", in any order and spacing,
/// followed by blanks and a line end. Throws InputError with the byte of `text`.
NpyHeader parse_npy_header(std::string_view text, const std::string& path);

/// In entries, of an array without gaps.
Shape strides_of(const Shape& shape, bool fortran_order);

}  // namespace mscomp

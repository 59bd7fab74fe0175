// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace mscomp {

/// Shapes begin .. end-1.
struct ShapeRange {
    int begin = 0, end = 0;
    int size() const { return end - begin; }
};

/// "A:B", "A:", ":B" or ":" within 0 .. shape_count. Throws UsageError.
ShapeRange parse_shape_range(std::string_view text, int shape_count);

/// One file stem per shape: the names, with what no file name should have replaced by "_"; preceded
/// by the index if they would not all differ. No two shapes share a file and none leaves its
/// folder.
std::vector<std::string> shape_file_names(const std::vector<std::string>& names);

}  // namespace mscomp

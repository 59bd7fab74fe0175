// SPDX-License-Identifier: MIT
// A square of two triangles, which tests write down in every format.
#pragma once

#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

inline const std::vector<Point> kPoints{{0, 0, 0}, {1, 0.5, 0}, {1, 1, -2e-3}, {0, 1, 0}};
inline const std::vector<Face> kFaces{{0, 1, 2}, {0, 2, 3}};

/// `text` with every `from` in it turned into `to`.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
        text.replace(at, from.size(), to);
    }
    return text;
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include "mscomp/base/mesh_data.h"

namespace mscomp {

inline double dot(const Point& p, const Point& q) {
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
}

}  // namespace mscomp

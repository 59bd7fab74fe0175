// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <span>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

inline Eigen::Map<const Eigen::Vector3d> vec(const Point& point) {
    return Eigen::Map<const Eigen::Vector3d>(point.data());
}

inline bool all_finite(std::span<const float> values) {
    return std::ranges::all_of(values, [](float x) { return std::isfinite(x); });
}

}  // namespace mscomp

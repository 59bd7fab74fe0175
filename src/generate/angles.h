// SPDX-License-Identifier: MIT
#pragma once

#include <numbers>

namespace mscomp {

inline constexpr double kPi = std::numbers::pi;

inline double radians(double degrees) { return degrees * kPi / 180; }

}  // namespace mscomp

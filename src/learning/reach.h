// SPDX-License-Identifier: MIT
#pragma once

#include <span>

namespace mscomp {

/// How far a component around a centre reaches: it may act where the distance from it is less. That
/// is `range`, or less where more than `share` of the vertices are nearer; one vertex at least.
double reach_of(std::span<const double> distances, double range, double share);

}  // namespace mscomp

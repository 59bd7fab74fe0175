// SPDX-License-Identifier: MIT
#pragma once

#include "mscomp/model/keys.h"

namespace mscomp {

/// Of whole numbers: what no use needs more of, and sums of a few of them still fit.
inline constexpr Bounds kCount{1, 1'000'000'000};
inline constexpr Bounds kCountOrNone{0, 1'000'000'000};
/// Of components: memory is taken for each of them as often as the mesh has vertices.
inline constexpr Bounds kComponentCount{1, 10'000};

}  // namespace mscomp

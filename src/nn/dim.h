// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "mscomp/base/feature_set.h"

namespace mscomp::nn {

inline constexpr std::int64_t kDim = kFeatureDim;  // numbers per vertex, for sizes

}  // namespace mscomp::nn

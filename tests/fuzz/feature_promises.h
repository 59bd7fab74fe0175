// SPDX-License-Identifier: MIT
// What holds for every feature set that a reader gives.
#pragma once

#include "mscomp/base/feature_set.h"

namespace mscomp::fuzz {

/// Counts agree, numbers are finite, faces refer to vertices.
void check_sound(const FeatureSet& set);

/// `read` is what was written, bit for bit.
void check_same(const FeatureSet& read, const FeatureSet& written);

}  // namespace mscomp::fuzz

// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "mscomp/base/feature_set.h"

namespace mscomp {

/// Writes the feature file (safetensors): features [N,V,9] f32, vertices [N,V,3] f32, reference
/// [V,3] f64, faces [F,3] i32, rotation [N,3,3] f64, translation [N,3] f64, and where the set has
/// them consistency_energy, consistency_gap, largest_jump [N] f64; metadata: format_version,
/// weights, layout, source, and names and warnings as JSON lists of strings.
/// Throws IoError, or NumericalError if a number is not finite; then nothing is written.
void write_features(const std::string& path, const FeatureSet& set);

/// Reads it back. The three [N] f64 and all metadata may be missing (files of other programs);
/// names then become shape_0000, ... and weights cotangent. Throws IoError, or InputError for
/// missing tensors, shapes that do not match each other, numbers that are not finite, faces out of
/// range, and other versions, layouts or weights.
FeatureSet read_features(const std::string& path);

}  // namespace mscomp

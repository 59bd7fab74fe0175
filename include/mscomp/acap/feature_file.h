// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "mscomp/base/feature_set.h"

namespace mscomp {

/// Writes the feature file (safetensors): features [N,V,9] f32, vertices [N,V,3] f32, reference
/// [V,3] f64, faces [F,3] i32, rotation [N,3,3] f64, translation [N,3] f64, consistency_energy [N]
/// f64, largest_jump [N] f64; metadata: format_version, names, weights, layout, source, warnings.
void write_features(const std::string& path, const FeatureSet& set);

/// Reads it back. consistency_energy, largest_jump, names and warnings may be missing (other
/// programs); names then become shape_0000, ... Throws IoError or InputError.
FeatureSet read_features(const std::string& path);

}  // namespace mscomp

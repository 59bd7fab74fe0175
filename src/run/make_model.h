// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "mscomp/base/distance_rows.h"
#include "mscomp/model/config.h"
#include "mscomp/model/kind.h"
#include "mscomp/model/model_file.h"

namespace mscomp {

/// An untrained model of the configured kind for the mesh and the scale of `context`; `shapes` as
/// ModelPlace::shapes. Borrows context and distances.
std::unique_ptr<LearnedModel> make_model(const Config& config, const ModelContext& context,
                                         DistanceRows& distances, ModelUse use, int shapes);

}  // namespace mscomp

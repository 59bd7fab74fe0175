// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "mscomp/model/components.h"
#include "mscomp/model/model_file.h"

namespace mscomp {

/// A component in every report: docs/components.md. `support` and `moving` are parts of the places
/// that the model of `context` knows, `support_vertices` is how many; vertices are told as the
/// files number them.
nlohmann::ordered_json component_json(const Component& component, const ModelContext& context);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "mscomp/model/components.h"

namespace mscomp {

/// A component in every report: docs/components.md. `support` and `moving` are parts of the
/// vertices, `support_vertices` is how many.
nlohmann::ordered_json component_json(const Component& component, int vertex_count);

}  // namespace mscomp

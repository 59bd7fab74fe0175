// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "mscomp/model/components.h"
#include "mscomp/model/model_file.h"

namespace mscomp {

/// What the components of a run are like, for reports.
struct ComponentReport {
    nlohmann::ordered_json kept_per_level;  // [number, ...]
    nlohmann::ordered_json support_mean;    // share of the vertices, mean of the kept components
    nlohmann::ordered_json list;            // one object per component, dropped ones too
    nlohmann::ordered_json cosine;          // of the kept ones: ids, mean, max, matrix
};                                          // means over nothing are null

/// `components` of a model of `level_count` levels.
ComponentReport component_report(const std::vector<Component>& components, int level_count,
                                 const ModelContext& context);

}  // namespace mscomp

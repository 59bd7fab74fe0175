// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "mscomp/base/metric_scale.h"
#include "mscomp/model/components.h"
#include "mscomp/model/config.h"

namespace mscomp {

/// What an error is.
struct ErrorOfRows {
    int width = 0;                             // entries of a row
    const MetricScale* metric = nullptr;       // scales rows; null: they count as they are
    std::optional<double> training_squares{};  // that of the training shapes; none: not known
};

/// Decides which of all components of a model are kept, with the reasons, what they cost and what
/// is merged. `codes` are those of the training shapes.
void filter_components(std::vector<Component>& components, const CodeTable& codes,
                       const FilterConfig& filter, const ErrorOfRows& error);

}  // namespace mscomp

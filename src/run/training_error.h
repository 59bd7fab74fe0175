// SPDX-License-Identifier: MIT
#pragma once

#include <span>

#include "mscomp/base/metric_scale.h"
#include "mscomp/base/shape_features.h"
#include "mscomp/model/shape_model.h"

namespace mscomp {

/// Σ |X - Dec(z)|² over the shapes `which` with their codes, of features as `scale` scales them, of
/// positions in the unit of the mesh. The same bits for any number of threads.
double squared_error(const ShapeModel& model, const ShapeSet& shapes, std::span<const int> which,
                     const CodeTable& codes, const MetricScale& scale);

}  // namespace mscomp

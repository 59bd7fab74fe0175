// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/model/shape_model.h"

namespace mscomp {

/// Standard deviation of every code over the shapes, (K), of n degrees of freedom; zeros without
/// shapes.
std::vector<float> code_deviations(const CodeTable& codes);

/// Root mean square of the deviations of all codes; those of the prior N(0, I) have 1.
double code_deviation(const CodeTable& codes);

}  // namespace mscomp

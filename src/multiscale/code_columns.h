// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/model/shape_model.h"
#include "multiscale/ball_components.h"
#include "multiscale/row_map.h"

namespace mscomp {

/// How the rows of shapes change with each code, (K).
std::vector<CodeColumn> code_columns(const BallComponents& components, const RowMap& map);

}  // namespace mscomp

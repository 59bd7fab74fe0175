// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mscomp/base/metric_scale.h"
#include "mscomp/model/components.h"

namespace mscomp {

/// Inner products (K,K) of what a change of each code by 1 does, Σ_v Σ_c s_vc² C_i,vc C_j,vc: the
/// secant between both ends of each component, all other codes at those of the reference, s what
/// the metric scales a row by (null: 1). Rows have `width` entries. The same bits for any number of
/// threads.
Eigen::MatrixXd change_products(const std::vector<Component>& components, int width,
                                const MetricScale* metric);

}  // namespace mscomp

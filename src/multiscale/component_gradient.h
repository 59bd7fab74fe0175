// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"

namespace mscomp {

/// Adds weight Σ_m z_m g_m at every vertex to `gradient`, beside all_values(): the derivative in
/// the components, at fixed codes z (K,shapes), of what has the derivatives `by_row` in the mapped
/// features of each shape, times `weight`.
void add_component_gradient(const BallComponents& components, const Eigen::MatrixXd& codes,
                            const MetricRows& by_row, double weight, std::vector<float>& gradient);

/// F, the squared error of mapped features at joint codes, mean over the shapes; overwrites
/// `gradient` with its derivative in the components at these codes. But for the damping of the
/// codes it is also that where they follow, since they minimise F.
double feature_error(const MetricRows& rows, const BallComponents& components,
                     std::vector<float>& gradient);

}  // namespace mscomp

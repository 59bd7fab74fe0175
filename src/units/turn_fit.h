// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"
#include "units/turn_field.h"

namespace mscomp {

/// Turns B (E,3) of components on their balls, by least squares on fixed codes (N,K) over what they
/// carry: min Σ_n |A (x_n - Σ_k z_nk B_k)|² + μ w |x_n - Σ_k z_nk B_k|², A = TurnField::added_up,
/// w what A makes of the square of a turn and μ = 0.01, by twenty steps of conjugate gradients from
/// `start`. What is cut off where a component hardly turns adds up along a limb: the fit makes good
/// for it where the component is left.
BallComponents fitted_to_carry(const TurnField& field, const MetricRows& turns,
                               const Eigen::MatrixXd& codes, BallComponents start);

}  // namespace mscomp

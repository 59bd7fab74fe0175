// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "units/quiet_codes.h"
#include "units/unit_codes.h"

namespace mscomp {

/// Units that switch on and off, from nothing but the inner products (N,N) of all pairs of shapes
/// and their `basis` (method §10, code route, steps 2 to 5): quiet read-outs that at least two
/// shapes agree on, without those that others predict, fitted without negative codes where they
/// explain the shapes.
UnitCodes code_route(const Eigen::MatrixXd& gram, const ShapeBasis& basis, double noise);

}  // namespace mscomp

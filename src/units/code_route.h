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

/// What it finds at the noise at which the most units are found again.
struct FoundUnits {
    UnitCodes units;
    /// (K) part of the random subsets in which the unit was found again.
    std::vector<double> again;
    double noise = 0;
    double unexplained = 1;  // part of the squares of all shapes

    /// How many of them, on average over the subsets.
    double found_again() const;
    /// The same times the part of the squares that they explain: what noises are compared by.
    double score() const;
};

/// Of noises from 0.003 to 0.08 that with the best score, subsets being two of four fifths of the
/// shapes; of equals the one with fewer units. Subsets depend on what shapes
/// are, not on their order. Shapes that are the reference (zero) count for nothing.
FoundUnits find_units(const Eigen::MatrixXd& gram);

}  // namespace mscomp

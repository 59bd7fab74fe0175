// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "units/space_route.h"
#include "units/unit_codes.h"

namespace mscomp {

/// Units, and how sure they are.
struct FoundUnits {
    UnitCodes units;
    /// (K) part of some random subsets of four fifths of the shapes in which the unit was found
    /// again: four for the code route, two for the space route.
    std::vector<double> again;
    /// (K) |correlation| of its codes in groups of like shapes with what is read there by units
    /// found without the group, mean over the groups; 0 where it was not found.
    std::vector<double> held_out;
    double noise = 0;
    double unexplained = 1;  // part of the squares of all shapes

    /// How many of them, on average over the subsets.
    double found_again() const;
    /// The same times the part of the squares that they explain: what noises are compared by.
    double score() const;
    /// Median of the units; 0 for none.
    double median_held_out() const;
};

/// What the code route finds in inner products (N,N) of shapes at the best of noises from 0.003 to
/// 0.08, of equals the one with fewer units. Subsets and groups depend on what shapes are, not on
/// their order. Shapes that are the reference (zero) count for nothing.
FoundUnits find_switching_units(const Eigen::MatrixXd& gram);

/// What the space route finds in inner products of relative rotations and a sample of them, at the
/// best of noises from 0.1 to 0.5 of the length of all shapes; more is taken for noise only where
/// units leave a twentieth of the squares. Subsets and groups are those of other inner products of
/// the same shapes, `like`.
FoundUnits find_turning_units(const Eigen::MatrixXd& gram, const EdgeSample& sample,
                              const Eigen::MatrixXd& like);

/// Whether a set whose units of the code route move most of the mesh is made of joints (method
/// §10): their codes in shapes that were left out correlate with those of all more than those of
/// the other route do, and they explain two thirds of the squares.
bool are_turning(const FoundUnits& switching, const FoundUnits& turning);

}  // namespace mscomp

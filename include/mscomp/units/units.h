// SPDX-License-Identifier: MIT
#pragma once

#include "mscomp/model/kind.h"

namespace mscomp {

inline constexpr int kMostUnits = 10'000;

/// How units are looked for (method §10).
enum class UnitRoute {
    automatic,  // codes where their units are of a place, else both, and what is read in shapes
                // that were left out chooses
    codes,      // as codes that rest in most shapes
    space       // as turns that rest along most edges
};

/// What the configuration of the kind holds for itself (method §10).
struct UnitSettings {
    int components = 0;  // at most so many, those that move most; 0: as many as there are
    ShapeRows rows = ShapeRows::features;    // what they change
    UnitRoute route = UnitRoute::automatic;  // of positions codes alone
};

/// The kind `units`: few components, each one thing (method §10). What switches on and off is found
/// by linear read-outs of the shapes that are quiet at nearly all of them, in features or in
/// aligned positions; joints by changes of relative rotations that are quiet along nearly all
/// edges, and they decode through integrated rotations. Codes are joint least squares over all
/// components.
Kind units();

}  // namespace mscomp

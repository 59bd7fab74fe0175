// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/model/given_components.h"
#include "mscomp/model/kind.h"

namespace mscomp {

/// Components that act on balls of one size.
struct BallLevel {
    int components = 10;
    double sparsity_range = 0.4;  // geodesic radius, diameter = 1
    double max_support = 0.38;    // part of the vertices in a ball at most
};

/// How the start spreads its centres.
struct CenterSpread {
    int most = 4;          // centres within the radius
    double radius = 0.06;  // geodesic, diameter = 1
};

inline constexpr int kFewShapes = 24, kMostFilledUpTo = 4096;

/// What the configuration of the kind holds for itself (method §9).
struct MultiscaleSettings {
    int global_components = 4;  // without a limit to their support, before the levels
    std::vector<BallLevel> levels{{8, 0.4, 0.36}, {16, 0.35, 0.28}, {32, 0.25, 0.19}};
    CenterSpread spread;
    /// Of the components' least squares, as a part of the mean square of a code; what it leaves
    /// open is as at the neighbours.
    double damping = 0.01;
    int rounds = 30;  // epochs of alternating least squares; those beyond lower the error in space
    /// Fewer than kFewShapes training shapes decide by cross-validation whether global components
    /// and mixed shapes help.
    bool select = true;
    bool mirror = true;  // learns from the mirror images, too, where the reference is symmetric
    double between = 0;  // part of the patches of mixed shapes that lie between two shapes
    double feature_share = 0.3;  // what the error of features counts beside that in space
};

/// Levels as the components of another model fill them, so that a training can begin with these
/// (train.start): as many components, and the range and the largest share that hold the support of
/// each, rounded up to thousandths.
std::vector<BallLevel> levels_around(const GivenComponents& given, DistanceRows& distances);

/// The kind `multiscale`: components on balls of the surface, level by level, fitted to the shapes
/// by alternating least squares on the sum of all levels; codes are joint least squares over all
/// components.
Kind multiscale();

}  // namespace mscomp

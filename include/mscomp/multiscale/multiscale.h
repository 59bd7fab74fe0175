// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/model/kind.h"

namespace mscomp {

/// Components that act on balls of one size.
struct BallLevel {
    int components = 10;
    double sparsity_range = 0.4;  // geodesic radius, diameter = 1
    double max_support = 0.38;    // part of the vertices in a ball at most
};

/// What an error of a feature counts as: the same at every vertex, or as the area around it.
enum class FeatureMetric { vertices, area };

/// How the start spreads its centres.
struct CenterSpread {
    int most = 4;          // centres within the radius
    double radius = 0.06;  // geodesic, diameter = 1
};

/// What the configuration of the kind holds for itself (method §9).
struct MultiscaleSettings {
    int global_components = 0;  // without a limit to their support, before the levels
    std::vector<BallLevel> levels{{10, 0.4, 0.38}, {50, 0.35, 0.27}};
    FeatureMetric metric = FeatureMetric::area;
    CenterSpread spread;
    int rounds = 30;        // of alternating least squares
    double damping = 1e-3;  // of the components' least squares, relative to the mean square of a code
};

/// The kind `multiscale`: components on balls of the surface, level by level, fitted to the shapes
/// by alternating least squares on the sum of all levels; codes are joint least squares over all
/// components.
Kind multiscale();

}  // namespace mscomp

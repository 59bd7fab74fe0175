// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/base/feature_set.h"

namespace mscomp {

enum class EdgeWeights { cotangent, authors, uniform };
EdgeWeights parse_edge_weights(const std::string& name);  // throws UsageError
std::string to_string(EdgeWeights weights);

struct ExtractOptions {
    EdgeWeights weights = EdgeWeights::cotangent;
    bool align = true;  // move every shape to the reference by the best rigid motion
};

/// ACAP features of `sequence` relative to `reference` (V positions, same connectivity), method §1:
/// alignment, deformation gradients with the normal pseudo-edge, polar decomposition, consistent
/// logarithms. Deterministic for any number of threads.
/// Throws MeshError if the reference has no area; everything odd but workable goes into warnings.
FeatureSet extract_features(const MeshSequence& sequence, const std::vector<Point>& reference,
                            const ExtractOptions& options = {},
                            const std::function<void(int done, int total)>& progress = {});

}  // namespace mscomp

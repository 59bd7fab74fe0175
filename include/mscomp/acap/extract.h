// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mscomp/acap/edge_weights.h"
#include "mscomp/acap/feature_rows.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/acap/mesh/shape_source.h"
#include "mscomp/acap/placed_features.h"

namespace mscomp {

struct ExtractOptions {
    EdgeWeights weights = EdgeWeights::cotangent;
    bool align = true;  // move every shape to the reference by the best rigid motion
    /// What vertex_places() found; it is asked where nothing is given.
    std::optional<VertexPlaces> places{};
};

/// How many of the shapes are done; one call at a time, from any thread. May throw, to stop.
using ExtractProgress = std::function<void(int done, int total)>;

/// Where the V vertices of `reference` and all shapes of `source` lie on the surface: vertices that
/// coincide in every shape are one place. Shapes are read only if vertices of the reference
/// coincide, and no more of them than it takes. Throws what reading a shape throws.
VertexPlaces vertex_places(const ShapeSource& source, const std::vector<Point>& reference);

/// What extract_features will return, before there is anything in it: names, reference, weights,
/// and arrays of N zeros for the numbers per shape.
PlacedFeatures feature_outline(const ShapeSource& source, const std::vector<Point>& reference,
                               const ExtractOptions& options = {});

/// ACAP features of the shapes of `source` relative to `reference` (V positions, same
/// connectivity), method §1: alignment, deformation gradients with the normal pseudo-edge, polar
/// decomposition, consistent logarithms, all of it on the surface of places: vertices that coincide
/// have the same feature, those without a face that of the reference, and no say in anything. A
/// reference far from the origin is moved there, so that float32 can hold `vertices`; `translation`
/// knows. The rows go to `rows`, everything else is returned
/// (`features` and `vertices` stay empty). Shapes are read once, and memory does not grow with
/// their number. The same bits for any number of threads and any kind of rows.
/// Throws MeshError if the reference has no area or a shape another size, and what reading a shape
/// throws; everything odd but workable goes into warnings.
PlacedFeatures extract_features(const ShapeSource& source, const std::vector<Point>& reference,
                                const ExtractOptions& options, FeatureRows& rows,
                                const ExtractProgress& progress = {});

/// The same with everything in memory.
PlacedFeatures extract_features(const MeshSequence& sequence, const std::vector<Point>& reference,
                                const ExtractOptions& options = {},
                                const ExtractProgress& progress = {});

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mscomp/acap/edge_weights.h"
#include "mscomp/acap/mesh/shape_source.h"
#include "mscomp/acap/placed_features.h"
#include "mscomp/base/feature_set.h"

namespace mscomp {

/// What a file that can be converted holds: shapes, or features with what belongs to them.
struct Contents {
    std::unique_ptr<ShapeSource> shapes;  // exactly one of these two
    std::optional<PlacedFeatures> features;
    std::vector<std::string> notes;  // what the file lacks and where it was taken from, what it has
                                     // beyond
    bool took_reference = false;     // something of Supplement::reference was needed
};

/// Stands in for what a file does not hold.
struct Supplement {
    std::string reference_path;  // of `reference`, for messages
    std::optional<TriangleMesh> reference;
    EdgeWeights weights = EdgeWeights::authors;
};

/// Makes a whole set out of one with `features` (N,V,9) where everything else may be empty:
/// reference and faces from `supplement`, vertices by lossless reconstruction, no motions, names
/// shape_0000, ...; each is noted. `path` is only used in messages. Throws UsageError if there is
/// no reference, InputError if it has another V.
Contents complete_features(FeatureSet set, int shape_count, int vertex_count,
                           const std::string& path, const Supplement& supplement);

/// Adds "shape_0000", ... for files without names.
std::vector<std::string> numbered_names(int count);

/// The vertices of a feature set, borrowed: moved back to where the input stood, or as they are,
/// aligned to the reference.
class FeatureShapes final : public ShapeSource {
  public:
    FeatureShapes(const FeatureSet& set, bool aligned) : set_(set), aligned_(aligned) {}

    const std::vector<std::string>& names() const override { return set_.names; }
    const std::vector<Face>& faces() const override { return set_.reference.faces; }
    int vertex_count() const override { return set_.vertex_count(); }
    std::vector<Point> shape(int index) const override;

  private:
    const FeatureSet& set_;
    bool aligned_;
};

/// Called while a file is written, with the number of shapes done; may throw to stop it.
using ShapesDone = std::function<void(int done)>;

}  // namespace mscomp

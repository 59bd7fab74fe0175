// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/metric_scale.h"
#include "mscomp/base/shape_features.h"

namespace mscomp {

enum class FeatureCenter { reference, minmax };
/// Around the reference, r and S can have a factor each, one that suits both, or one that leaves
/// out what few vertices do.
enum class FeatureScale { shared, separate, robust };

/// Where an extreme value of the training features was found.
struct FeatureExtreme {
    float value = 0;
    int shape = -1, vertex = -1, channel = -1;
};

struct FeatureScaler;

/// What values the r and the S channels of some shapes take.
class FeatureRanges {
  public:
    /// Over `shapes`, which are read once, one after the other, and forgotten then. `roots` (V) are
    /// those of the metric; empty: 1 everywhere. Throws UsageError if there is none or one that
    /// `features` do not have, NumericalError if a value is not finite.
    FeatureRanges(const ShapeFeatures& features, std::span<const int> shapes,
                  std::vector<float> roots = {});
    /// `scale` has no meaning for minmax, whose ranges are separate.
    FeatureScaler scaler(FeatureCenter center, FeatureScale scale = FeatureScale::separate) const;

  private:
    struct Group {
        FeatureExtreme smallest, largest;
        double deviation = 0;  // from the reference's feature times the root, largest
    };
    void add(std::span<const float> values, int shape);

    void add_deviations(std::span<const float> values);
    double robust_deviation() const;
    double root(std::size_t v) const { return roots_.empty() ? 1 : static_cast<double>(roots_[v]); }

    std::vector<float> roots_;
    std::vector<double> largest_;  // (V), root times the largest deviation of an entry
    std::array<Group, 2> groups_;  // r, S
};

/// The affine map between ACAP features and what the network sees, one map for the three r channels
/// and one for the six S channels, fitted on training shapes to [-0.95, 0.95] (method §1).
/// `reference`: (r, S) -> (factor_r r, factor_S (S - I)), `shared`: both factors the smaller one,
/// so that an error counts as far as it moves an edge, whether it turns or stretches it; `robust`:
/// both such that the largest entry of a vertex is within 0.95 for all vertices but those with the
/// largest 0.1 % of the metric's weight (method §9); all with the metric's root at the vertex.
/// `minmax`: the two global ranges mapped linearly, without a metric. A range below 1e-5 (rounding
/// of float32 features) counts as zero and gives zeros. Values outside the training range are not
/// clamped.
struct FeatureScaler : MetricScale {
    FeatureCenter center = FeatureCenter::reference;
    std::vector<FeatureExtreme> extremes;  // smallest and largest r, smallest and largest S entry

    /// Fits the ranges over `shapes` (indices into `set`). Throws as FeatureRanges does.
    static FeatureScaler fit(const FeatureSet& set, std::span<const int> shapes,
                             FeatureCenter center);
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "mscomp/base/channel_scale.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/shape_features.h"

namespace mscomp {

enum class FeatureCenter { reference, minmax };
/// Around the reference, r and S can have a factor each or one that suits both.
enum class FeatureScale { shared, separate };

/// Where an extreme value of the training features was found.
struct FeatureExtreme {
    float value = 0;
    int shape = -1, vertex = -1, channel = -1;
};

struct FeatureScaler;

/// What values the r and the S channels of some shapes take.
class FeatureRanges {
  public:
    /// Over `shapes`, which are read once, one after the other, and forgotten then. Throws
    /// UsageError if there is none or one that `features` do not have, NumericalError if a value is
    /// not finite.
    FeatureRanges(const ShapeFeatures& features, std::span<const int> shapes);
    /// `scale` has no meaning for minmax, whose ranges are separate.
    FeatureScaler scaler(FeatureCenter center, FeatureScale scale = FeatureScale::separate) const;

  private:
    struct Group {
        FeatureExtreme smallest, largest;
        double deviation = 0;  // from the reference's feature, largest
    };
    void add(std::span<const float> values, int shape);

    std::array<Group, 2> groups_;  // r, S
};

/// The affine map between ACAP features and what the network sees, one map for the three r channels
/// and one for the six S channels, fitted on training shapes to [-0.95, 0.95] (method §1).
/// `reference`: (r, S) -> (factor_r r, factor_S (S - I)), `shared`: both factors the smaller one,
/// so that an error counts as far as it moves an edge, whether it turns or stretches it; `minmax`:
/// the two global ranges mapped linearly. A range below 1e-5 (rounding of float32 features) counts
/// as zero and gives zeros. Values outside the training range are not clamped.
struct FeatureScaler : ChannelScale {
    FeatureCenter center = FeatureCenter::reference;
    std::vector<FeatureExtreme> extremes;  // smallest and largest r, smallest and largest S entry

    /// Fits the ranges over `shapes` (indices into `set`). Throws as FeatureRanges does.
    static FeatureScaler fit(const FeatureSet& set, std::span<const int> shapes,
                             FeatureCenter center);
};

}  // namespace mscomp

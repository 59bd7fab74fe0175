// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>

#include "mscomp/base/feature_set.h"

namespace mscomp {

/// The affine map of the nine channels of a feature to what a model works on: scaled = (feature -
/// offset) * factor. By default features stay as they are. A factor of 0 is for channels that do
/// not vary: they scale to 0 and come back as the offset.
struct ChannelScale {
    std::array<double, kFeatureDim> offset{};
    std::array<double, kFeatureDim> factor{1, 1, 1, 1, 1, 1, 1, 1, 1};

    /// In place over any number of rows of nine; in double, rounded to float once.
    void scale(std::span<float> features) const;
    void unscale(std::span<float> features) const;
};

}  // namespace mscomp

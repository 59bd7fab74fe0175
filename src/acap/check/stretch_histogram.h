// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

namespace mscomp {

/// How often |S - I| (largest entry of a vertex) fell into each of the logarithmic bins.
class StretchHistogram {
  public:
    void add(double value);
    void add(const StretchHistogram& other);
    /// Upper end of the bin in which `share` of all values is reached; 0 without values.
    double quantile(double share) const;

  private:
    static constexpr int kBinsPerDecade = 128;
    static constexpr int kLowestDecade = -8, kHighestDecade = 8;
    static constexpr int kBins = kBinsPerDecade * (kHighestDecade - kLowestDecade) + 1;
    std::array<std::int64_t, kBins> counts_{};
};

/// The share of vertices that says what is usual in a set.
inline constexpr double kMostStretches = 0.999;

/// Whether a stretch is far beyond the `usual` one, so that the scale of all features suffers.
inline bool is_stretch_outlier(double stretch, double usual) {
    constexpr double kOutlier = 8.0;
    return stretch > kOutlier * usual && stretch > 1;
}

}  // namespace mscomp

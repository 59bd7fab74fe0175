// SPDX-License-Identifier: MIT
#include "stretch_histogram.h"

#include <algorithm>
#include <cmath>

namespace mscomp {

void StretchHistogram::add(double value) {
    if (!(value >= 0)) return;
    const double place = (std::log10(value) - kLowestDecade) * kBinsPerDecade;
    ++counts_[static_cast<std::size_t>(std::clamp(place, 0.0, kBins - 1.0))];
}

void StretchHistogram::add(const StretchHistogram& other) {
    for (std::size_t bin = 0; bin < counts_.size(); ++bin) counts_[bin] += other.counts_[bin];
}

double StretchHistogram::quantile(double share) const {
    std::int64_t total = 0, seen = 0;
    for (const std::int64_t count : counts_) total += count;
    if (total == 0) return 0;
    for (std::size_t bin = 0; bin < counts_.size(); ++bin) {
        seen += counts_[bin];
        if (static_cast<double>(seen) < share * static_cast<double>(total)) continue;
        return std::pow(10.0, kLowestDecade + static_cast<double>(bin + 1) / kBinsPerDecade);
    }
    return std::pow(10.0, kHighestDecade);
}

}  // namespace mscomp

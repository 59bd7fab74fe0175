// SPDX-License-Identifier: MIT
#include "learning/reach.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace mscomp {

double reach_of(std::span<const double> distances, double range, double share) {
    const auto most = std::max<std::size_t>(
        1, static_cast<std::size_t>(share * static_cast<double>(distances.size())));
    if (most >= distances.size()) return range;
    // Exactly the vertices nearer than the one after the last that fits.
    std::vector<double> sorted(distances.begin(), distances.end());
    const auto first_outside = sorted.begin() + static_cast<std::ptrdiff_t>(most);
    std::nth_element(sorted.begin(), first_outside, sorted.end());
    return std::min(range, *first_outside);
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/base/channel_scale.h"

#include <cstddef>

namespace mscomp {

void ChannelScale::scale(std::span<float> features) const {
    for (std::size_t k = 0; k < features.size(); ++k) {
        const std::size_t channel = k % kFeatureDim;
        features[k] = static_cast<float>((static_cast<double>(features[k]) - offset[channel]) *
                                         factor[channel]);
    }
}

void ChannelScale::unscale(std::span<float> features) const {
    for (std::size_t k = 0; k < features.size(); ++k) {
        const std::size_t channel = k % kFeatureDim;
        const double deviation =
            factor[channel] != 0 ? static_cast<double>(features[k]) / factor[channel] : 0.0;
        features[k] = static_cast<float>(deviation + offset[channel]);
    }
}

}  // namespace mscomp

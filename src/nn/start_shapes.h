// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "mscomp/base/index.h"
#include "nn/lane_batch.h"

namespace mscomp::nn {

/// The shapes that a start looks at: up to 256, evenly chosen, in passes of `batch`.
struct StartShapes {
    StartShapes(const ScaledFeatures& all, std::span<const int> which, int most)
        : features(all), batch(at(most)) {
        constexpr std::size_t kMostShapes = 256;
        const std::size_t wanted = std::min(which.size(), kMostShapes);
        for (std::size_t i = 0; i < wanted; ++i) shapes.push_back(which[i * which.size() / wanted]);
    }

    std::span<const int> pass(std::size_t first) const {
        return std::span(shapes).subspan(first, std::min(batch, shapes.size() - first));
    }
    std::int64_t count() const { return static_cast<std::int64_t>(shapes.size()); }

    const ScaledFeatures& features;
    std::vector<int> shapes;
    std::size_t batch;
};

/// What the encoder gives while its convolution is the identity.
inline double squashed(double input) { return std::tanh(input); }

}  // namespace mscomp::nn

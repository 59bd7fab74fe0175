// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "deflation_residual.h"
#include "mscomp/base/distance_rows.h"
#include "mscomp/nn/lane_batch.h"

namespace mscomp::nn {

/// The shapes that a start looks at: up to 256, evenly chosen, in passes of `batch`.
struct StartShapes {
    StartShapes(const ScaledFeatures& all, std::span<const int> which, int most);

    std::span<const int> pass(std::size_t first) const;
    std::int64_t count() const { return static_cast<std::int64_t>(shapes.size()); }

    const ScaledFeatures& features;
    std::vector<int> shapes;
    std::size_t batch;
};

struct FoundComponent {
    int center = 0;
    DeflationDirection direction;
    double energy = -1;  // explained by it
};

/// Indices of those of `vertices` where a component around `center` may act, rising.
using FreePlaces = std::function<std::vector<int>(int center, std::span<const int> vertices)>;

/// Takes `components` directions out of `residual` one after the other: around the strongest
/// vertex, then around where the direction is longest, as long as that explains more. A component
/// for which there is nothing left is all zero and has the centre that was tried last.
std::vector<FoundComponent> deflate(DeflationResidual& residual, int components,
                                    DistanceRows& distances, const FreePlaces& free_places);

/// Writes a direction into component weights (V,width), its first channels where width is less
/// than nine; others stay as they are.
template <class T>
void write_direction(const DeflationResidual& residual, const DeflationDirection& direction,
                     std::int64_t width, std::span<T> row);

}  // namespace mscomp::nn

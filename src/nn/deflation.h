// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "deflation_residual.h"
#include "mscomp/base/distance_rows.h"
#include "nn/lane_batch.h"

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

/// How many vertices a start looks at besides the strongest.
inline constexpr int kCandidates = 64;

/// Vertices spread over the mesh, each as far as possible from those before it; the first is 0.
std::vector<int> spread_vertices(DistanceRows& distances, int most);

/// Takes `components` directions out of `residual` one after the other: around the one of
/// `candidates` or the strongest vertex where most energy is left within reach, then around where
/// the direction is longest, as long as that explains more. The energy of a whole ball counts,
/// since a component has to serve all of it: single hot vertices would leave the ground between
/// them to too few components. A component for which there is nothing left is all zero and has the
/// centre that was tried last.
std::vector<FoundComponent> deflate(DeflationResidual& residual, int components,
                                    DistanceRows& distances, const FreePlaces& free_places,
                                    std::span<const int> candidates);

/// Writes a direction into component weights (V,width), its first channels where width is less
/// than nine; others stay as they are.
template <class T>
void write_direction(const DeflationResidual& residual, const DeflationDirection& direction,
                     std::int64_t width, std::span<T> row);

}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
#pragma once

#include "mscomp/base/feature_set.h"
#include "mscomp/base/vertex_places.h"

namespace mscomp {

/// A feature set that knows where the V vertices of its reference lie on the surface.
struct PlacedFeatures : FeatureSet {
    VertexPlaces places;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/acap/surface_shapes.h"

#include <mutex>

#include "mscomp/base/feature_set.h"

namespace mscomp {

struct SurfaceShapes::Rows {
    std::once_flag once;
    std::vector<float> values;

    std::span<const float> of(const VertexPlaces& places, std::span<const float> all, int width) {
        std::call_once(once, [&] { values = places.of_places(all, width); });
        return values;
    }
};

SurfaceShapes::SurfaceShapes(const ShapeSet& shapes, const VertexPlaces& places)
    : shapes_(shapes), places_(places) {
    if (places.are_all_vertices()) return;
    features_ = std::make_unique<Rows[]>(at(shapes.shape_count()));
    vertices_ = std::make_unique<Rows[]>(at(shapes.shape_count()));
}
SurfaceShapes::~SurfaceShapes() = default;

std::span<const float> SurfaceShapes::shape(int index) const {
    if (!features_) return shapes_.shape(index);
    return features_[at(index)].of(places_, shapes_.shape(index), kFeatureDim);
}

std::span<const float> SurfaceShapes::vertices(int index) const {
    if (!vertices_) return shapes_.vertices(index);
    return vertices_[at(index)].of(places_, shapes_.vertices(index), 3);
}

}  // namespace mscomp

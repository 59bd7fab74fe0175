// SPDX-License-Identifier: MIT
#pragma once

#include <numeric>
#include <span>
#include <vector>

#include "learning/mixed_features.h"
#include "mscomp/base/random.h"
#include "small_training.h"

namespace mscomp::nn {

inline VertexOrder as_it_is(int vertices) {
    VertexOrder order;
    order.to_user.resize(static_cast<std::size_t>(vertices));
    std::iota(order.to_user.begin(), order.to_user.end(), 0);
    order.to_internal = order.to_user;
    return order;
}

/// Random features of some shapes on a sphere, and mixes of some of these.
struct Mixing {
    TriangleMesh mesh;
    SphereDistances distances;
    std::vector<float> features;
    MemoryFeatures memory;
    VertexOrder order;
    MixedFeatures mixed;

    explicit Mixing(std::vector<int> shapes = {0, 1, 2, 3, 4, 5}, int levels = 2,
                    std::uint64_t seed = 5, double between = 0)
        : mesh(shapes::icosphere(levels)),
          distances(mesh.vertices),
          features(random_features(6, mesh.vertex_count())),
          memory(features, mesh.vertex_count()),
          order(as_it_is(mesh.vertex_count())),
          mixed(memory, shapes, distances, order.to_user, seed, between) {}

    static std::vector<float> random_features(int shape_count, int vertices) {
        const CounterRandom random(31, 0);
        std::vector<float> values(static_cast<std::size_t>(shape_count * vertices * 9));
        for (std::size_t i = 0; i < values.size(); ++i) {
            values[i] = static_cast<float>(random.normal(i));
        }
        return values;
    }
    int vertices() const { return mesh.vertex_count(); }
    std::vector<float> row(int m) const {
        const std::span<const float> span = mixed.shape(memory.shape_count() + m);
        return {span.begin(), span.end()};
    }
};

}  // namespace mscomp::nn

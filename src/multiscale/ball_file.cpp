// SPDX-License-Identifier: MIT
// The components of a model on balls as arrays of a model file.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mscomp/base/error.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/model/stored_arrays.h"
#include "multiscale/ball_model.h"

namespace mscomp {
namespace {

constexpr const char* kCenters = "components/centers";
constexpr const char* kFirst = "components/first";        // (K+1) into what follows
constexpr const char* kVertices = "components/vertices";  // of each ball, rising
constexpr const char* kValues = "components/values";      // (..,width)
constexpr const char* kParents = "components/parents";    // (K) where they were begun with

/// Vertices of one ball. Throws CheckpointError unless they rise and are of the mesh.
std::vector<int> checked_vertices(std::span<const int> vertices, int vertex_count,
                                  const std::string& path) {
    int before = -1;
    for (const int v : vertices) {
        if (v <= before || v >= vertex_count) {
            throw CheckpointError(
                path, fmt::format("vertex {} of a component behind {}, of {} vertices", v, before,
                                  vertex_count));
        }
        before = v;
    }
    return {vertices.begin(), vertices.end()};
}

}  // namespace

void BallModel::save_balls(StoredArrays& arrays) const {
    std::vector<int> centers, vertices;
    std::vector<std::int64_t> first{0};
    std::vector<float> values;
    for (int k = 0; k < components_.count(); ++k) {
        const Ball& ball = components_.balls()[at(k)];
        const std::vector<float> own = components_.component(k);
        centers.push_back(ball.center);
        vertices.insert(vertices.end(), ball.vertices.begin(), ball.vertices.end());
        values.insert(values.end(), own.begin(), own.end());
        first.push_back(static_cast<std::int64_t>(vertices.size()));
    }
    const std::int64_t entries = first.back();
    arrays.keep<int>(kCenters, {components_.count()}, std::move(centers));
    arrays.keep<std::int64_t>(kFirst, {components_.count() + 1}, std::move(first));
    arrays.keep<int>(kVertices, {entries}, std::move(vertices));
    arrays.keep<float>(kValues, {entries, components_.width()}, std::move(values));
    if (!parents_.empty()) arrays.keep<int>(kParents, {components_.count()}, parents_);
}

BallComponents BallModel::load_balls(const SafetensorsFile& file) const {
    const int width = map_.width();
    const auto centers = file.data<int>(kCenters, {-1});
    const auto count = static_cast<std::int64_t>(centers.size());
    const auto first = file.data<std::int64_t>(kFirst, {count + 1});
    const auto vertices = file.data<int>(kVertices, {-1});
    const auto entries = static_cast<std::int64_t>(vertices.size());
    const auto values = file.data<float>(kValues, {entries, width});
    if (first[0] != 0 || first[at(count)] != entries || !std::ranges::is_sorted(first)) {
        throw CheckpointError(file.path(), fmt::format("{} does not rise to the {} entries of {}",
                                                       kFirst, entries, kVertices));
    }
    std::vector<Ball> balls(at(count));
    for (std::size_t k = 0; k < balls.size(); ++k) {
        if (centers[k] < 0 || centers[k] >= vertex_count()) {
            throw CheckpointError(
                file.path(), fmt::format("centre {} of {} vertices", centers[k], vertex_count()));
        }
        balls[k] = {centers[k],
                    checked_vertices(vertices.subspan(at(first[k]), at(first[k + 1] - first[k])),
                                     vertex_count(), file.path())};
    }
    BallComponents components(vertex_count(), std::move(balls), width);
    for (int k = 0; k < components.count(); ++k) {
        components.set_component(k, values.subspan(at(first[at(k)]) * at(width)));
    }
    return components;
}

/// None for a file without. A parent is of a coarser level.
std::vector<int> BallModel::load_parents(const SafetensorsFile& file) const {
    if (!file.contains(kParents)) return {};
    const auto parents = file.data<int>(kParents, {code_count()});
    int first = 0;  // of the level
    for (const LevelSize& level : levels()) {
        for (int k = first; k < first + level.codes(); ++k) {
            if (parents[at(k)] >= -1 && parents[at(k)] < first) continue;
            throw CheckpointError(
                file.path(), fmt::format("component {} as the parent of {}", parents[at(k)], k));
        }
        first += level.codes();
    }
    return {parents.begin(), parents.end()};
}

}  // namespace mscomp

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

constexpr const char* kComponents = "components";
constexpr const char* kCenters = "centers";
constexpr const char* kFirst = "first";                 // (K+1) into what follows
constexpr const char* kVertices = "vertices";           // of each ball, rising
constexpr const char* kValues = "values";               // (..,width)
constexpr const char* kParents = "components/parents";  // (K) where they were begun with

std::string name_in(const std::string& prefix, const char* name) {
    return fmt::format("{}/{}", prefix, name);
}

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

void keep_components(const std::string& prefix, const BallComponents& components,
                     StoredArrays& arrays) {
    std::vector<int> centers, vertices;
    std::vector<std::int64_t> first{0};
    std::vector<float> values;
    for (int k = 0; k < components.count(); ++k) {
        const Ball& ball = components.balls()[at(k)];
        const std::vector<float> own = components.component(k);
        centers.push_back(ball.center);
        vertices.insert(vertices.end(), ball.vertices.begin(), ball.vertices.end());
        values.insert(values.end(), own.begin(), own.end());
        first.push_back(static_cast<std::int64_t>(vertices.size()));
    }
    const std::int64_t entries = first.back();
    arrays.keep<int>(name_in(prefix, kCenters), {components.count()}, std::move(centers));
    arrays.keep<std::int64_t>(name_in(prefix, kFirst), {components.count() + 1}, std::move(first));
    arrays.keep<int>(name_in(prefix, kVertices), {entries}, std::move(vertices));
    arrays.keep<float>(name_in(prefix, kValues), {entries, components.width()}, std::move(values));
}

BallComponents stored_components(const SafetensorsFile& file, const std::string& prefix,
                                 int vertex_count, int width) {
    const auto centers = file.data<int>(name_in(prefix, kCenters), {-1});
    const auto count = static_cast<std::int64_t>(centers.size());
    const auto first = file.data<std::int64_t>(name_in(prefix, kFirst), {count + 1});
    const auto vertices = file.data<int>(name_in(prefix, kVertices), {-1});
    const auto entries = static_cast<std::int64_t>(vertices.size());
    const auto values = file.data<float>(name_in(prefix, kValues), {entries, width});
    if (first[0] != 0 || first[at(count)] != entries || !std::ranges::is_sorted(first)) {
        throw CheckpointError(file.path(), fmt::format("{} does not rise to the {} entries of {}",
                                                       kFirst, entries, kVertices));
    }
    std::vector<Ball> balls(at(count));
    for (std::size_t k = 0; k < balls.size(); ++k) {
        if (centers[k] < 0 || centers[k] >= vertex_count) {
            throw CheckpointError(
                file.path(), fmt::format("centre {} of {} vertices", centers[k], vertex_count));
        }
        balls[k] = {centers[k],
                    checked_vertices(vertices.subspan(at(first[k]), at(first[k + 1] - first[k])),
                                     vertex_count, file.path())};
    }
    BallComponents components(vertex_count, std::move(balls), width);
    for (int k = 0; k < components.count(); ++k) {
        components.set_component(k, values.subspan(at(first[at(k)]) * at(width)));
    }
    return components;
}

void BallModel::save_balls(StoredArrays& arrays) const {
    keep_components(kComponents, components_, arrays);
    if (!parents_.empty()) arrays.keep<int>(kParents, {components_.count()}, parents_);
}

BallComponents BallModel::load_balls(const SafetensorsFile& file) const {
    return stored_components(file, kComponents, vertex_count(), map_.width());
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

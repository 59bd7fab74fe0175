// SPDX-License-Identifier: MIT
#include "mscomp/convert/contents.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

void supply_reference(Contents& contents, const std::string& path, const Supplement& supplement,
                      int vertex_count) {
    TriangleMesh& mesh = contents.features->reference;
    const bool lacks_vertices = mesh.vertices.empty(), lacks_faces = mesh.faces.empty();
    if (!lacks_vertices && !lacks_faces) return;
    const char* const missing = !lacks_faces      ? "reference"
                                : !lacks_vertices ? "faces"
                                                  : "reference and faces";
    if (!supplement.reference) {
        throw UsageError(fmt::format("{} has no {}; give a mesh that has them: --reference MESH",
                                     path, missing));
    }
    if (supplement.reference->vertex_count() != vertex_count) {
        throw InputError({supplement.reference_path},
                         fmt::format("{} vertices, but {} has {}",
                                     supplement.reference->vertex_count(), path, vertex_count));
    }
    if (lacks_vertices) mesh.vertices = supplement.reference->vertices;
    if (lacks_faces) mesh.faces = supplement.reference->faces;
    contents.took_reference = true;
    contents.notes.push_back(fmt::format("{} are those of {}", missing, supplement.reference_path));
}

/// Throws InputError where the reference of `path` is no surface.
LosslessReconstruction lossless_of(const FeatureSet& set, const std::string& path) {
    try {
        return {set.reference, parse_edge_weights(set.weights)};
    } catch (const MeshError& error) {
        throw InputError(
            {path}, fmt::format("vertices cannot be made from the features: {}", error.what()));
    }
}

void supply_vertices(Contents& contents, const std::string& path, int shape_count) {
    FeatureSet& set = *contents.features;
    if (!set.vertices.empty()) return;
    const LosslessReconstruction lossless = lossless_of(set, path);
    const auto size = at(set.vertex_count()) * 3;
    set.vertices.resize(at(shape_count) * size);
    parallel_for(shape_count, [&](std::int64_t shape) {
        float* out = set.vertices.data() + at(shape) * size;
        const ReconstructedShape solved = lossless.solve(set.shape(static_cast<int>(shape)));
        for (const Point& point : solved.vertices) {
            for (const double x : point) *out++ = static_cast<float>(x);
        }
    });
    const auto bad = std::find_if_not(set.vertices.begin(), set.vertices.end(),
                                      [](float x) { return std::isfinite(x); });
    if (bad != set.vertices.end()) {
        const auto shape = static_cast<std::size_t>(bad - set.vertices.begin()) / size;
        throw InputError({path}, fmt::format("vertices cannot be made from the features: those of "
                                             "shape {} are beyond float32",
                                             shape));
    }
    contents.notes.emplace_back("vertices are made from the features");
}

}  // namespace

std::vector<std::string> numbered_names(int count) {
    std::vector<std::string> names;
    for (int i = 0; i < count; ++i) names.push_back(fmt::format("shape_{:04}", i));
    return names;
}

Contents complete_features(FeatureSet set, int shape_count, int vertex_count,
                           const std::string& path, const Supplement& supplement) {
    const auto count = at(shape_count);
    Contents contents;
    contents.features = PlacedFeatures{std::move(set), {}};
    FeatureSet& features = *contents.features;
    supply_reference(contents, path, supplement, vertex_count);
    if (features.weights.empty()) {
        features.weights = to_string(supplement.weights);
        contents.notes.push_back("weights are taken to be " + features.weights);
    }
    if (features.names.empty()) {
        features.names = numbered_names(shape_count);
        contents.notes.emplace_back("names are shape_0000, ...");
    }
    supply_vertices(contents, path, shape_count);
    if (features.rotation.empty() || features.translation.empty()) {
        if (features.rotation.empty()) {
            features.rotation.assign(count, {1, 0, 0, 0, 1, 0, 0, 0, 1});
        }
        if (features.translation.empty()) features.translation.assign(count, {0, 0, 0});
        contents.notes.emplace_back("there are no motions");
    }
    return contents;
}

std::vector<Point> FeatureShapes::shape(int index) const {
    const auto i = at(index);
    const auto count = at(set_.vertex_count());
    const auto& rotation = set_.rotation[i];
    const auto& translation = set_.translation[i];
    const float* place = set_.vertices.data() + i * count * 3;
    std::vector<Point> points(count);
    for (Point& point : points) {
        Point stored{place[0], place[1], place[2]};
        place += 3;
        if (aligned_) {
            point = stored;
            continue;
        }
        // aligned = rotation * input + translation
        for (std::size_t k = 0; k < 3; ++k) stored[k] -= translation[k];
        for (std::size_t k = 0; k < 3; ++k) {
            point[k] =
                rotation[k] * stored[0] + rotation[3 + k] * stored[1] + rotation[6 + k] * stored[2];
        }
    }
    return points;
}

}  // namespace mscomp

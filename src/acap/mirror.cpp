// SPDX-License-Identifier: MIT
#include "mscomp/acap/mirror.h"

#include <algorithm>
#include <cmath>

#include "edge_weights.h"
#include "mirror_plane.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/points.h"
#include "mscomp/base/random.h"
#include "surface_tree.h"

namespace mscomp {
namespace {

using Eigen::Vector3d;

constexpr int kFewPoints = 500, kManyPoints = 2000;
/// What a step has to lower the cost by, where planes are compared and where the best is refined.
constexpr double kSomeDescent = 1e-3, kAnyDescent = 1e-9;
/// A fit is better than one before it only by more than this, as a distance in radii, squared.
constexpr double kAsGood = 1e-10;
constexpr double kNoWeight = 1e-6;
/// A point that faces as it should is taken if no more radii farther than the nearest of all.
constexpr double kFarther = 0.01;

std::vector<int> vertices_with_faces(const TriangleMesh& mesh) {
    std::vector<char> has_face(mesh.vertices.size(), 0);
    for (const Face& face : mesh.faces) {
        for (const int v : face) has_face[at(v)] = 1;
    }
    std::vector<int> result;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (has_face[at(v)] != 0) result.push_back(v);
    }
    return result;
}

/// The reference with its vertices in the unit ball, those without faces at its centre.
struct UnitMesh {
    TriangleMesh mesh;
    std::vector<int> used;  // vertices with faces
    Point center{};
    double scale = 1;  // NaN if there is no such ball

    explicit UnitMesh(const TriangleMesh& reference) : used(vertices_with_faces(reference)) {
        std::vector<Point> points;
        points.reserve(used.size());
        for (const int v : used) points.push_back(reference.vertices[at(v)]);
        scale = unit_ball_scale(points);
        if (!(scale > 0)) return;
        center = centroid(points);
        mesh.vertices.resize(reference.vertices.size());
        for (const int v : used) {
            const Point from_center = minus(reference.vertices[at(v)], center);
            for (std::size_t k = 0; k < 3; ++k) mesh.vertices[at(v)][k] = scale * from_center[k];
        }
        mesh.faces = reference.faces;
    }
    /// At most `count` of the used vertices, drawn once and for all; in their order, in which one
    /// is often near the next.
    std::vector<Vector3d> sample(int count) const {
        std::vector<int> drawn = CounterRandom(0, 0).permutation(static_cast<int>(used.size()));
        drawn.resize(std::min(drawn.size(), at(count)));
        std::ranges::sort(drawn);
        std::vector<Vector3d> points;
        for (const int i : drawn) points.emplace_back(as_vector(mesh.vertices[at(used[at(i)])]));
        return points;
    }
};

MirrorPlane best_plane(const UnitMesh& unit, const SurfaceTree& surface) {
    const std::vector<MirrorPlane> starts = start_planes(unit.mesh);
    const std::vector<Vector3d> few = unit.sample(kFewPoints);
    std::vector<MirrorFit> fits(starts.size());
    parallel_for(static_cast<std::int64_t>(starts.size()), [&](std::int64_t i) {
        fits[at(i)] = fitted_mirror(surface, few, starts[at(i)], kSomeDescent);
    });
    MirrorFit best = fits.front();
    for (const MirrorFit& fit : fits) {
        if (fit.cost < best.cost - kAsGood) best = fit;
    }
    return fitted_mirror(surface, unit.sample(kManyPoints), best.plane, kAnyDescent).plane;
}

/// Sums of the normals around each vertex, the larger faces counting more.
std::vector<Vector3d> vertex_normals(const TriangleMesh& mesh) {
    std::vector<Vector3d> result(mesh.vertices.size(), Vector3d::Zero());
    for (const Face& face : mesh.faces) {
        const auto a = as_vector(mesh.vertices[at(face[0])]);
        const Vector3d normal = (as_vector(mesh.vertices[at(face[1])]) - a)
                                    .cross(as_vector(mesh.vertices[at(face[2])]) - a);
        for (const int v : face) result[at(v)] += normal;
    }
    return result;
}

SurfaceLocation location(const Face& face, const Vector3d& weights) {
    const Vector3d kept =
        weights.unaryExpr([](double weight) { return weight < kNoWeight ? 0.0 : weight; });
    const double sum = kept.sum();
    SurfaceLocation result{face, {}};
    for (std::size_t k = 0; k < 3; ++k) {
        result.weights[k] = static_cast<float>(kept[static_cast<Eigen::Index>(k)] / sum);
    }
    return result;
}

/// Calls body(i) for every used vertex, the i-th.
template <class Body>
void for_used(const UnitMesh& unit, Body&& body) {
    const Chunks chunks{static_cast<std::int64_t>(unit.used.size()), 256};
    parallel_for(chunks.count(), [&](std::int64_t chunk) {
        for (std::int64_t i = chunks.begin(chunk); i < chunks.end(chunk); ++i) body(at(i));
    });
}

/// Of the used vertices, reflected.
std::vector<SurfacePoint> nearest_points(const UnitMesh& unit, const SurfaceTree& surface,
                                         const MirrorPlane& plane) {
    std::vector<SurfacePoint> result(unit.used.size());
    for_used(unit, [&](std::size_t i) {
        result[i] =
            surface.nearest(plane.reflected(as_vector(unit.mesh.vertices[at(unit.used[i])])));
    });
    return result;
}

double mean_distance(const std::vector<SurfacePoint>& points) {
    double sum = 0;
    for (const SurfacePoint& point : points) sum += std::sqrt(point.square);
    return sum / static_cast<double>(points.size());
}

std::vector<SurfaceLocation> partners(const UnitMesh& unit, const SurfaceTree& surface,
                                      const MirrorPlane& plane,
                                      const std::vector<SurfacePoint>& nearest) {
    const std::vector<Vector3d> normals = vertex_normals(unit.mesh);
    std::vector<SurfaceLocation> result(unit.mesh.vertices.size());
    for (int v = 0; v < unit.mesh.vertex_count(); ++v) result[at(v)].corners = {v, v, v};
    for_used(unit, [&](std::size_t i) {
        const std::size_t v = at(unit.used[i]);
        const SurfacePoint facing = surface.nearest_facing(
            plane.reflected(as_vector(unit.mesh.vertices[v])), plane.matrix() * normals[v],
            std::sqrt(nearest[i].square) + kFarther);
        const SurfacePoint& chosen = facing.face >= 0 ? facing : nearest[i];
        result[v] = location(unit.mesh.faces[at(chosen.face)], chosen.weights);
    });
    return result;
}

}  // namespace

Point Mirror::reflected(const Point& point) const {
    const Vector3d image = matrix * as_vector(point) + translation;
    return {image.x(), image.y(), image.z()};
}

std::optional<Mirror> mirror_of(const TriangleMesh& reference, double most) {
    const UnitMesh unit(reference);
    if (!(unit.scale > 0)) return std::nullopt;
    const SurfaceTree surface(unit.mesh);
    if (surface.is_empty()) return std::nullopt;
    const MirrorPlane plane = best_plane(unit, surface);
    const std::vector<SurfacePoint> nearest = nearest_points(unit, surface, plane);
    const double distance = mean_distance(nearest);
    if (!(distance <= most)) return std::nullopt;
    const double offset = plane.normal.dot(as_vector(unit.center)) + plane.offset / unit.scale;
    return Mirror{plane.matrix(), 2 * offset * plane.normal, distance,
                  partners(unit, surface, plane, nearest)};
}

}  // namespace mscomp

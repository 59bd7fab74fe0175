// SPDX-License-Identifier: MIT
#include "mirror_plane.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "edge_weights.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kNearlyAsLong = 0.25;  // of the larger of two variances
constexpr int kBetween = 4;             // steps from one axis to the next

constexpr double kHuber = 0.02;
constexpr int kIterations = 50;
constexpr double kLeastDamping = 1e-9, kMostDamping = 1e3;
constexpr double kNoStep = 1e-12;
/// On the surface but for rounding: the way to its nearest point has no direction.
constexpr double kTouches = 1e-12;

struct Moments {
    double area = 0;
    Vector3d centroid = Vector3d::Zero();
    Matrix3d covariance = Matrix3d::Zero();
};

/// Exact moments of the triangles.
Moments area_moments(const TriangleMesh& mesh) {
    Moments result;
    Vector3d first = Vector3d::Zero();
    Matrix3d second = Matrix3d::Zero();
    for (const Face& face : mesh.faces) {
        const Vector3d a = as_vector(mesh.vertices[at(face[0])]);
        const Vector3d b = as_vector(mesh.vertices[at(face[1])]);
        const Vector3d c = as_vector(mesh.vertices[at(face[2])]);
        const double area = (b - a).cross(c - a).norm() / 2;
        const Vector3d sum = a + b + c;
        result.area += area;
        first += area / 3 * sum;
        second +=
            area / 12 *
            (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    }
    result.centroid = first / result.area;
    result.covariance = second / result.area - result.centroid * result.centroid.transpose();
    return result;
}

/// Two vectors that span the plane.
Eigen::Matrix<double, 3, 2> tangents(const Vector3d& normal) {
    Eigen::Matrix<double, 3, 2> result;
    result.col(0) = normal.unitOrthogonal();
    result.col(1) = normal.cross(result.col(0));
    return result;
}

/// How the cost changes with the plane: normal + tangents · x, offset + x_2.
struct Linearised {
    double cost = 0;
    Matrix3d matrix = Matrix3d::Zero();
    Vector3d gradient = Vector3d::Zero();
};

struct Residual {
    double distance = 0;
    Vector3d derivative = Vector3d::Zero();
};

/// With m the unit direction from the surface, the reflected p' = p - 2 (n·p - d) n has the
/// distance m·(p' - q), whose derivative by n along e is -2 ((e·p)(m·n) + (n·p - d)(m·e)).
Residual residual(const SurfaceTree& surface, const MirrorPlane& plane,
                  const Eigen::Matrix<double, 3, 2>& along, const Vector3d& point) {
    const Vector3d image = plane.reflected(point);
    const SurfacePoint nearest = surface.nearest(image);
    Residual result;
    result.distance = std::sqrt(nearest.square);
    const Vector3d away = result.distance > kTouches
                              ? Vector3d((image - nearest.position) / result.distance)
                              : surface.normal(nearest);
    const double across = away.dot(plane.normal);
    const double height = plane.normal.dot(point) - plane.offset;
    result.derivative.head<2>() =
        -2 * (across * along.transpose() * point + height * along.transpose() * away);
    result.derivative[2] = 2 * across;
    return result;
}

Linearised linearised(const SurfaceTree& surface, const MirrorPlane& plane,
                      std::span<const Vector3d> points) {
    const Eigen::Matrix<double, 3, 2> along = tangents(plane.normal);
    std::vector<Residual> residuals(points.size());
    const Chunks chunks{static_cast<std::int64_t>(points.size()), 64};
    parallel_for(chunks.count(), [&](std::int64_t chunk) {
        for (std::int64_t i = chunks.begin(chunk); i < chunks.end(chunk); ++i) {
            residuals[at(i)] = residual(surface, plane, along, points[at(i)]);
        }
    });
    Linearised sum;
    for (const auto& [distance, derivative] : residuals) {
        const double weight = distance > kHuber ? kHuber / distance : 1;
        sum.cost += distance > kHuber ? (2 * distance - kHuber) * kHuber : distance * distance;
        sum.matrix += weight * derivative * derivative.transpose();
        sum.gradient += weight * distance * derivative;
    }
    const double share = 1 / static_cast<double>(points.size());
    return {share * sum.cost, share * sum.matrix, share * sum.gradient};
}

MirrorPlane moved(const MirrorPlane& plane, const Vector3d& step) {
    return {(plane.normal + tangents(plane.normal) * step.head<2>()).normalized(),
            plane.offset + step[2]};
}

}  // namespace

std::vector<MirrorPlane> start_planes(const TriangleMesh& mesh) {
    const Moments moments = area_moments(mesh);
    const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(moments.covariance);
    std::vector<MirrorPlane> planes;
    const auto add = [&](const Vector3d& direction) {
        const Vector3d normal = direction.normalized();
        planes.push_back({normal, normal.dot(moments.centroid)});
    };
    const auto axis = [&](int k) -> Vector3d { return axes.eigenvectors().col(k); };
    const auto nearly_as_long = [&](int shorter, int longer) {
        const Vector3d& variances = axes.eigenvalues();
        return variances[longer] - variances[shorter] <= kNearlyAsLong * variances[longer];
    };
    for (int k = 2; k >= 0; --k) add(axis(k));
    for (const auto& [i, j] : {std::pair(2, 1), std::pair(1, 0), std::pair(2, 0)}) {
        if (!nearly_as_long(j, i)) continue;
        for (int k = 1; k < 2 * kBetween; ++k) {
            const double angle = std::numbers::pi / 2 * k / kBetween;
            if (k != kBetween) add(std::cos(angle) * axis(i) + std::sin(angle) * axis(j));
        }
    }
    if (nearly_as_long(0, 2)) {
        for (const double x : {-1, 1}) {
            for (const double y : {-1, 1}) add(axis(2) + x * axis(1) + y * axis(0));
        }
    }
    return planes;
}

MirrorFit fitted_mirror(const SurfaceTree& surface, std::span<const Vector3d> points,
                        const MirrorPlane& start, double least) {
    MirrorPlane plane = start;
    Linearised here = linearised(surface, plane, points);
    double damping = 1e-6;
    for (int i = 0; i < kIterations && damping <= kMostDamping; ++i) {
        const Matrix3d matrix =
            here.matrix + (damping * here.matrix.trace() + 1e-300) * Matrix3d::Identity();
        const Vector3d step = -matrix.ldlt().solve(here.gradient);
        if (!(step.norm() > kNoStep)) break;
        const MirrorPlane next = moved(plane, step);
        const Linearised there = linearised(surface, next, points);
        if (!(there.cost < here.cost)) {
            damping = std::max(100 * damping, 1e-3);
            continue;
        }
        const bool is_least = here.cost - there.cost <= least * here.cost;
        plane = next;
        here = there;
        damping = std::max(damping / 10, kLeastDamping);
        if (is_least) break;
    }
    return {plane, here.cost};
}

}  // namespace mscomp

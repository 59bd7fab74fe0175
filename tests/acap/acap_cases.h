// SPDX-License-Identifier: MIT
// What the tests of acap share: deformations with known features, and access to them.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "mscomp/acap/extract.h"
#include "mscomp/base/index.h"
#include "mscomp/base/random.h"
#include "shapes.h"

namespace mscomp::cases {

using Eigen::Matrix3d;
using Eigen::Vector3d;

inline constexpr double kPi = std::numbers::pi;

inline Vector3d vec(const Point& p) { return {p[0], p[1], p[2]}; }
inline Point point(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

inline TriangleMesh mapped(TriangleMesh mesh, const std::function<Vector3d(const Vector3d&)>& map) {
    for (Point& p : mesh.vertices) p = point(map(vec(p)));
    return mesh;
}

inline Matrix3d rotation_about(const Vector3d& axis, double angle) {
    return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// Twist around z: rotation by turns * 2π * z / length.
inline TriangleMesh twisted(const TriangleMesh& mesh, double turns, double length) {
    return mapped(mesh, [=](const Vector3d& p) -> Vector3d {
        return rotation_about(Vector3d::UnitZ(), 2 * std::numbers::pi * turns * p.z() / length) * p;
    });
}

/// A sphere with bumps: no symmetry, no flat ring.
inline TriangleMesh bumpy_sphere(int levels) {
    return mapped(shapes::icosphere(levels), [](const Vector3d& p) -> Vector3d {
        return p * (1 + 0.2 * std::sin(3 * p.x() + 1) * std::cos(2 * p.y()) + 0.1 * p.z());
    });
}

/// Bends, twists and stretches smoothly, well below π.
inline Vector3d wobble(const Vector3d& p) {
    return rotation_about({1, 0.5, 0.2}, 0.8 * p.z() + 0.3 * p.x()) * p + 0.1 * p.cwiseProduct(p);
}

inline MeshSequence sequence_of(const std::vector<TriangleMesh>& meshes) {
    MeshSequence sequence;
    sequence.faces = meshes.front().faces;
    for (const TriangleMesh& mesh : meshes) {
        sequence.names.push_back("shape_" + std::to_string(sequence.names.size()));
        sequence.shapes.push_back(mesh.vertices);
    }
    return sequence;
}

inline FeatureSet extract_one(const TriangleMesh& reference, const TriangleMesh& shape,
                              bool align = false, EdgeWeights weights = EdgeWeights::cotangent) {
    return extract_features(sequence_of({shape}), reference.vertices, {weights, align});
}

inline const float* feature(const FeatureSet& set, int vertex, int shape = 0) {
    return set.shape(shape).data() + at(vertex) * kFeatureDim;
}
inline Vector3d rotation_vector(const FeatureSet& set, int vertex, int shape = 0) {
    const float* f = feature(set, vertex, shape);
    return {f[0], f[1], f[2]};
}
inline Matrix3d stretch(const FeatureSet& set, int vertex, int shape = 0) {
    const float* f = feature(set, vertex, shape);
    Matrix3d s;
    s << f[3], f[4], f[5], f[4], f[6], f[7], f[5], f[7], f[8];
    return s;
}
/// exp(r) by Rodrigues' formula as Eigen has it, independent of ours.
inline Matrix3d exp_of(const Vector3d& r) {
    return r.norm() > 0 ? rotation_about(r, r.norm()) : Matrix3d::Identity();
}

/// Fixed random numbers in [-1, 1].
class Draws {
  public:
    explicit Draws(std::uint64_t stream) : random_(17, stream) {}
    double next() { return 2 * random_.uniform(index_++) - 1; }
    Vector3d vector() {
        const double x = next(), y = next(), z = next();
        return {x, y, z};
    }
    Matrix3d matrix() {
        Matrix3d m;
        for (int row = 0; row < 3; ++row) m.row(row) = vector();
        return m;
    }
    Matrix3d rotation() {
        const Vector3d axis = vector();
        return rotation_about(axis, std::numbers::pi * next());
    }

  private:
    CounterRandom random_;
    std::uint64_t index_ = 0;
};

/// Largest entry, NaN counting as infinite.
template <class Matrix>
double largest(const Eigen::MatrixBase<Matrix>& m) {
    return m.allFinite() ? m.cwiseAbs().maxCoeff() : std::numeric_limits<double>::infinity();
}

}  // namespace mscomp::cases

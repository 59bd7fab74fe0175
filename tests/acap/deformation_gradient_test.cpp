// SPDX-License-Identifier: MIT
#include "acap/deformation_gradient.h"

#include <gtest/gtest.h>

#include "acap_cases.h"
#include "dense.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using namespace cases;

std::vector<Matrix3d> gradients(const TriangleMesh& reference, const TriangleMesh& shape,
                                EdgeWeights weights = EdgeWeights::cotangent) {
    return DeformationGradients(reference, weights).compute(shape.vertices).gradients;
}

Vector3d ring_normal(const TriangleMesh& mesh, int vertex) {
    Vector3d sum = Vector3d::Zero();
    for (const Face& f : mesh.faces) {
        if (f[0] != vertex && f[1] != vertex && f[2] != vertex) continue;
        const Vector3d a = vec(mesh.vertices[at(f[0])]), b = vec(mesh.vertices[at(f[1])]);
        sum += (b - a).cross(vec(mesh.vertices[at(f[2])]) - a).normalized();
    }
    return sum.normalized();
}

/// The least-squares problem of method §1 at one vertex, stacked row by row and solved by QR.
Matrix3d dense_gradient(const TriangleMesh& reference, const TriangleMesh& shape, int vertex,
                        const OneRings& rings, const std::vector<double>& weights) {
    const int begin = rings.offsets[at(vertex)], degree = rings.degree(vertex);
    Eigen::MatrixXd before(degree + 1, 3), after(degree + 1, 3);
    double length_before = 0, length_after = 0;
    for (int k = 0; k < degree; ++k) {
        const int j = rings.neighbors[at(begin + k)];
        const double root = std::sqrt(weights[at(begin + k)]);
        const Vector3d e = vec(reference.vertices[at(j)]) - vec(reference.vertices[at(vertex)]);
        const Vector3d f = vec(shape.vertices[at(j)]) - vec(shape.vertices[at(vertex)]);
        before.row(k) = root * e;
        after.row(k) = root * f;
        length_before += e.norm() / degree;
        length_after += f.norm() / degree;
    }
    before.row(degree) = 0.3 * length_before * ring_normal(reference, vertex);
    after.row(degree) = 0.3 * length_after * ring_normal(shape, vertex);
    return least_squares(before, after).transpose();
}

TEST(DeformationGradient, IsTheLeastSquaresSolutionAtEveryVertex) {
    const TriangleMesh closed = bumpy_sphere(2), open = shapes::cylinder(9, 6, 1, 3, false);
    for (const TriangleMesh& reference : {closed, open}) {
        const TriangleMesh shape = mapped(reference, wobble);
        for (const EdgeWeights kind : {EdgeWeights::cotangent, EdgeWeights::authors}) {
            const DeformationGradients map(reference, kind);
            const auto result = map.compute(shape.vertices).gradients;
            for (int i = 0; i < reference.vertex_count(); ++i) {
                const Matrix3d wanted =
                    dense_gradient(reference, shape, i, map.rings(), map.weights());
                ASSERT_LT(largest(result[at(i)] - wanted), 1e-12) << i;
            }
        }
    }
}

// A similarity p -> a R p + t has T = a R, in every unit.
TEST(DeformationGradient, SimilarityIsItsOwnGradient) {
    const Matrix3d turn = rotation_about({1, -1, 2}, 2.2);
    for (const TriangleMesh& mesh :
         {bumpy_sphere(2), shapes::grid(5, 4), shapes::cylinder(8, 4, 1, 2, true)}) {
        for (const double unit : {1e-8, 1.0, 1e8}) {
            const TriangleMesh reference =
                mapped(mesh, [=](const Vector3d& p) -> Vector3d { return unit * p; });
            const TriangleMesh shape = mapped(reference, [&](const Vector3d& p) -> Vector3d {
                return 1.5 * (turn * p) + unit * Vector3d(1, 2, 3);
            });
            for (const Matrix3d& gradient : gradients(reference, shape)) {
                ASSERT_LT(largest(gradient - 1.5 * turn), 1e-11);
            }
        }
    }
}

// In a flat mesh an in-plane linear map is met exactly, and the normal keeps its direction.
TEST(DeformationGradient, FlatGridTakesALinearMapExactly) {
    Matrix3d shear = Matrix3d::Identity();
    shear(0, 1) = 0.7;
    shear(1, 1) = 1.4;
    const TriangleMesh flat = shapes::grid(5, 5);
    const TriangleMesh shape =
        mapped(flat, [&](const Vector3d& p) -> Vector3d { return shear * p; });
    for (const Matrix3d& gradient : gradients(flat, shape)) {
        EXPECT_LT(largest(gradient.leftCols<2>() - shear.leftCols<2>()), 1e-13);
        EXPECT_LT(largest(gradient.col(2).head<2>()), 1e-13);
        EXPECT_GT(gradient(2, 2), 0.5);
    }
}

/// Every face twice, once each way round: the normals of all rings cancel.
TriangleMesh two_sided(TriangleMesh mesh) {
    const auto front = mesh.faces;
    for (const Face& f : front) mesh.faces.push_back({f[0], f[2], f[1]});
    return mesh;
}

// Folded rings: the direction of least spread still makes a rigid motion its own gradient.
TEST(DeformationGradient, FoldedRingsFollowARigidMotion) {
    const Matrix3d turn = rotation_about({1, 1, 3}, 3.0);
    for (const TriangleMesh& mesh : {two_sided(shapes::grid(5, 4)), two_sided(bumpy_sphere(1))}) {
        const DeformationGradients map(mesh, EdgeWeights::cotangent);
        EXPECT_EQ(map.folded_rings().count, mesh.vertex_count());
        const TriangleMesh shape =
            mapped(mesh, [&](const Vector3d& p) -> Vector3d { return turn * p; });
        const auto result = map.compute(shape.vertices);
        EXPECT_EQ(result.folded_rings.count, mesh.vertex_count());
        for (const Matrix3d& gradient : result.gradients) {
            EXPECT_LT(largest(gradient - turn), 1e-12);
        }
    }
}

TEST(DeformationGradient, IsolatedVertexGetsTheIdentity) {
    TriangleMesh mesh = bumpy_sphere(1);
    mesh.vertices.push_back({3, 3, 3});
    const DeformationGradients map(mesh, EdgeWeights::cotangent);
    EXPECT_EQ(map.isolated_vertices().count, 1);
    EXPECT_EQ(map.isolated_vertices().first, mesh.vertex_count() - 1);
    const TriangleMesh shape = mapped(mesh, wobble);
    EXPECT_EQ(map.compute(shape.vertices).gradients.back(), Matrix3d::Identity());
}

// A vertex whose only face has collapsed to a line takes the motion of its neighbours.
TEST(DeformationGradient, RingWithoutWidthFollowsItsNeighbors) {
    TriangleMesh mesh = shapes::grid(3, 3);
    mesh.vertices.push_back({0.5, 0, 0});
    mesh.faces.push_back({0, 1, 9});
    const DeformationGradients map(mesh, EdgeWeights::cotangent);
    EXPECT_EQ(map.degenerate_rings().count + map.folded_rings().count, 2);
    const Matrix3d turn = rotation_about({2, 1, 0}, 1.2);
    const TriangleMesh shape =
        mapped(mesh, [&](const Vector3d& p) -> Vector3d { return turn * p; });
    const auto result = map.compute(shape.vertices);
    EXPECT_EQ(result.zero_area_faces.count, 1);
    EXPECT_EQ(result.zero_area_faces.first, 8);
    for (const Matrix3d& gradient : result.gradients) EXPECT_LT(largest(gradient - turn), 1e-12);
}

TEST(DeformationGradient, ReferenceWithoutAreaIsRefused) {
    TriangleMesh line;
    line.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    line.faces = {{0, 1, 2}};
    EXPECT_THROW(DeformationGradients(line, EdgeWeights::cotangent), MeshError);
}

}  // namespace
}  // namespace mscomp

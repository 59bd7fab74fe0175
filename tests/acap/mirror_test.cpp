// SPDX-License-Identifier: MIT
// The plane that a mesh is mirror symmetric to, and who is whose mirror image.
#include <gtest/gtest.h>

#include <limits>

#include "mirror_cases.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/points.h"
#include "mscomp/generate/generate.h"

namespace mscomp {
namespace {

using namespace cases;

/// x → scale Q x + shift.
struct Placement {
    const char* name;
    double scale;
    Vector3d axis;
    double angle;
    Vector3d shift;

    Matrix3d turn() const { return rotation_about(axis, angle); }
    TriangleMesh of(const TriangleMesh& mesh) const {
        return mapped(
            mesh, [this](const Vector3d& p) -> Vector3d { return scale * (turn() * p) + shift; });
    }
};

class PlacedMirror : public testing::TestWithParam<Placement> {};

TEST_P(PlacedMirror, IsThePlaneThatTheBodyWasMadeWith) {
    const Placement& placement = GetParam();
    const TriangleMesh body = two_sided_body(3), mesh = placement.of(body);
    const std::optional<Mirror> mirror = mirror_of(mesh);
    ASSERT_TRUE(mirror);
    const Matrix3d M = placement.turn() * flipped_x() * placement.turn().transpose();
    EXPECT_LT(largest(mirror->matrix - M), 1e-6);
    EXPECT_LT(largest(mirror->translation - (placement.shift - M * placement.shift)),
              1e-6 * placement.scale);
    EXPECT_LT(mirror->distance, 1e-7);
    const std::vector<int> opposite = opposite_vertices(body);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const SurfaceLocation& partner = mirror->partners[at(v)];
        EXPECT_EQ(main_corner(partner), opposite[at(v)]) << "vertex " << v;
        EXPECT_LT((located(mesh, partner) - vec(mirror->reflected(mesh.vertices[at(v)]))).norm(),
                  1e-6 * placement.scale);
    }
}

INSTANTIATE_TEST_SUITE_P(Placements, PlacedMirror,
                         testing::Values(Placement{"AsMade", 1, {1, 0, 0}, 0, {0, 0, 0}},
                                         Placement{"Turned", 1, {1, 2, 3}, 1.1, {0, 0, 0}},
                                         Placement{"Far", 1, {-1, 2, 0.5}, 2.5, {300, -200, 500}},
                                         Placement{"Tiny", 1e-4, {0, 2, 1}, 0.4, {1e-3, 0, 0}},
                                         Placement{"Huge", 1e5, {3, 1, 1}, -1.9, {-1e6, 2e6, 0}}),
                         [](const auto& placement) { return placement.param.name; });

TEST(Mirror, IsAReflection) {
    const std::optional<Mirror> mirror =
        mirror_of(Placement{"", 2, {1, 2, 3}, 1.1, {4, 5, 6}}.of(two_sided_body_askew(3)));
    ASSERT_TRUE(mirror);
    const Matrix3d& M = mirror->matrix;
    EXPECT_LT(largest(M - M.transpose()), 1e-15);
    EXPECT_LT(largest(M * M - Matrix3d::Identity()), 1e-14);
    EXPECT_NEAR(M.determinant(), -1, 1e-14);
    EXPECT_LT(largest(M * mirror->translation + mirror->translation), 1e-12);  // twice is nothing
}

// Where vertices have no mirror images partners lie between them.
TEST(Mirror, PartnersLieOnTheSurface) {
    const TriangleMesh mesh = two_sided_body_askew(3);
    const std::optional<Mirror> mirror = mirror_of(mesh);
    ASSERT_TRUE(mirror);
    EXPECT_LT(largest(mirror->matrix - flipped_x()), 5e-3);
    EXPECT_LT(mirror->distance, 2e-3);
    double farthest_corner = 0;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const SurfaceLocation& partner = mirror->partners[at(v)];
        const Vector3d image = vec(mirror->reflected(mesh.vertices[at(v)]));
        EXPECT_LT((located(mesh, partner) - image).norm(), 0.012) << "vertex " << v;
        EXPECT_NEAR(partner.weights[0] + partner.weights[1] + partner.weights[2], 1, 1e-6);
        const Vector3d corner = vec(mesh.vertices[at(main_corner(partner))]);
        farthest_corner = std::max(farthest_corner, (corner - image).norm());
    }
    EXPECT_GT(farthest_corner, 0.1);
}

// The principal axes of a regular prism are any ones, so that its planes have to be searched for.
TEST(Mirror, IsFoundWhereThePrincipalAxesSayNothing) {
    for (const int sides : {3, 4, 5}) {
        const TriangleMesh frustum =
            mapped(shapes::cylinder(sides, 6, 1, 4, true), [](const Vector3d& p) -> Vector3d {
                return rotation_about({1, 2, 3}, 1) *
                       p.cwiseProduct(Vector3d(1 + 0.1 * p.z(), 1 + 0.1 * p.z(), 1));
            });
        const std::optional<Mirror> mirror = mirror_of(frustum);
        ASSERT_TRUE(mirror) << sides;
        EXPECT_LT(mirror->distance, 1e-7) << sides;
    }
}

TEST(Mirror, OfASphereIsAnyPlaneThroughItsCentre) {
    const std::optional<Mirror> mirror = mirror_of(shapes::icosphere(3));
    ASSERT_TRUE(mirror);
    EXPECT_LT(mirror->distance, 5e-3);
    EXPECT_LT(mirror->translation.norm(), 1e-2);
}

TEST(Mirror, OfAGeneratedHeadIsItsMiddle) {
    const MeshSequence sequence = generate_face(2, 0, 2000).sequence;
    const std::optional<Mirror> mirror = mirror_of({sequence.shapes[0], sequence.faces});
    ASSERT_TRUE(mirror);
    EXPECT_LT(largest(mirror->matrix - flipped_x()), 1e-6);
    EXPECT_LT(mirror->distance, 1e-6);
}

// One flat sheet on another that looks the other way, as closed lips do.
TEST(Mirror, PartnersFaceTheSameWayWhereTheSurfaceTouchesItself) {
    TriangleMesh mesh = shapes::grid(9, 5);
    const int sheet = mesh.vertex_count();
    for (int v = 0; v < sheet; ++v) mesh.vertices.push_back(mesh.vertices[at(v)]);
    const std::vector<Face> faces = mesh.faces;
    for (const auto& [a, b, c] : faces) mesh.faces.push_back({sheet + a, sheet + c, sheet + b});
    const std::optional<Mirror> mirror = mirror_of(mesh);
    ASSERT_TRUE(mirror);
    EXPECT_LT(largest(mirror->matrix - flipped_x()), 1e-6);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        EXPECT_EQ(main_corner(mirror->partners[at(v)]) < sheet, v < sheet) << "vertex " << v;
    }
}

/// A spiral: left-handed where its mirror image is right-handed.
TriangleMesh spiral() {
    return mapped(shapes::cylinder(16, 60, 0.4, 9, true), [](const Vector3d& p) -> Vector3d {
        const double angle = p.z(), radius = 2 + p.x() - 0.1 * p.z();
        return {radius * std::cos(angle), radius * std::sin(angle), 0.5 * p.z() + p.y()};
    });
}

TEST(Mirror, OfABodyThatIsNotSymmetricIsNone) {
    EXPECT_FALSE(mirror_of(spiral()));
    EXPECT_FALSE(mirror_of(mapped(two_sided_body(3), [](const Vector3d& p) -> Vector3d {
        return rotation_about({0, 1, 0}, 1.2 * p.y()) * p + Vector3d(0.5 * p.y() * p.z(), 0, 0);
    })));
}

TEST(Mirror, IsNoneExactlyAboveTheDistanceAllowed) {
    const std::optional<Mirror> mirror = mirror_of(spiral(), 1);
    ASSERT_TRUE(mirror);
    EXPECT_GT(mirror->distance, 0.02);
    EXPECT_TRUE(mirror_of(spiral(), mirror->distance));
    EXPECT_FALSE(mirror_of(spiral(), 0.999 * mirror->distance));
}

TEST(Mirror, DoesNotSeeVerticesWithoutAFace) {
    const TriangleMesh mesh = two_sided_body_askew(2);
    TriangleMesh strayed = mesh;
    strayed.vertices.push_back({1e6, 0, 0});
    const std::optional<Mirror> mirror = mirror_of(mesh), other = mirror_of(strayed);
    ASSERT_TRUE(mirror && other);
    EXPECT_EQ(mirror->matrix, other->matrix);
    EXPECT_EQ(mirror->translation, other->translation);
    EXPECT_EQ(mirror->distance, other->distance);
    const int stray = mesh.vertex_count();
    EXPECT_EQ(other->partners.back().corners, (std::array{stray, stray, stray}));
    EXPECT_EQ(other->partners.back().weights, (std::array{1.0F, 0.0F, 0.0F}));
}

TEST(Mirror, FacesWithoutAreaDoNoHarm) {
    TriangleMesh mesh = two_sided_body(2);
    for (int v = 0; v < 20; ++v) mesh.faces.push_back({v, v, v + 1});
    mesh.vertices.push_back(mesh.vertices[3]);
    mesh.faces.push_back({3, mesh.vertex_count() - 1, 7});
    const std::optional<Mirror> mirror = mirror_of(mesh);
    ASSERT_TRUE(mirror);
    EXPECT_LT(largest(mirror->matrix - flipped_x()), 1e-6);
}

TEST(Mirror, OfWhatHasNoSurfaceIsNone) {
    EXPECT_FALSE(mirror_of({}));
    EXPECT_FALSE(mirror_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}}));
    EXPECT_FALSE(mirror_of({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}}));
    TriangleMesh mesh = two_sided_body(1);
    mesh.vertices[5][1] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(mirror_of(mesh));
}

TEST(Mirror, IsTheSameForAnyNumberOfThreads) {
    const TriangleMesh mesh = mapped(two_sided_body_askew(4), wobble);
    set_thread_count(1);
    const std::optional<Mirror> one = mirror_of(mesh, 1);
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        const std::optional<Mirror> many = mirror_of(mesh, 1);
        EXPECT_EQ(one->matrix, many->matrix);
        EXPECT_EQ(one->translation, many->translation);
        EXPECT_EQ(one->distance, many->distance);
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            ASSERT_EQ(one->partners[at(v)].corners, many->partners[at(v)].corners);
            ASSERT_EQ(one->partners[at(v)].weights, many->partners[at(v)].weights);
        }
    }
    set_thread_count(0);
}

}  // namespace
}  // namespace mscomp

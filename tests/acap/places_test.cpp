// SPDX-License-Identifier: MIT
// Vertices that lie on each other in every shape are one place of the surface; vertices without a
// face are none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "acap_cases.h"
#include "base/temporary_folder.h"
#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/acap/surface_shapes.h"
#include "mscomp/base/points.h"
#include "seamed_meshes.h"

namespace mscomp {
namespace {

using namespace cases;
using testing::Contains;
using testing::HasSubstr;

constexpr int kAround = 12, kRings = 9;

TriangleMesh tube() { return shapes::cylinder(kAround, kRings, 1, 4, false); }
TriangleMesh seamed() { return shapes::seamed_tube(kAround, kRings, 1, 4); }
/// The vertex of tube() that lies where vertex v of seamed() does.
int in_tube(int v) { return v / (kAround + 1) * kAround + v % (kAround + 1) % kAround; }

std::vector<TriangleMesh> moving(const TriangleMesh& mesh) {
    return {mesh, mapped(mesh, wobble), twisted(mesh, 0.4, 4)};
}

PlacedFeatures extracted(const std::vector<TriangleMesh>& meshes) {
    return extract_features(sequence_of(meshes), meshes.front().vertices);
}

void expect_same_feature(const FeatureSet& set, int v, const FeatureSet& other, int w,
                         double tolerance) {
    for (int n = 0; n < set.shape_count(); ++n) {
        for (int k = 0; k < kFeatureDim; ++k) {
            ASSERT_NEAR(feature(set, v, n)[k], feature(other, w, n)[k], tolerance)
                << "shape " << n << ", vertices " << v << " and " << w;
        }
    }
}

TEST(Places, ASeamedTubeHasTheFeaturesOfTheClosedOne) {
    const PlacedFeatures closed = extracted(moving(tube())), open = extracted(moving(seamed()));
    EXPECT_EQ(open.places.coincident_count(), kRings);
    EXPECT_THAT(open.warnings, Contains(HasSubstr("9 vertices coincide with others")));
    // Weights of the alignment differ by nothing: it is by place, too.
    for (int v = 0; v < open.vertex_count(); ++v) {
        expect_same_feature(open, v, closed, in_tube(v), 1e-6);
    }
}

TEST(Places, ASoupHasTheFeaturesOfItsMesh) {
    const TriangleMesh mesh = bumpy_sphere(1);
    const FeatureSet welded = extracted(moving(mesh));
    std::vector<TriangleMesh> soups;
    for (const TriangleMesh& shape : moving(mesh)) soups.push_back(shapes::soup(shape));
    const PlacedFeatures soup = extracted(soups);
    EXPECT_EQ(soup.places.coincident_count(), soup.vertex_count() - mesh.vertex_count());
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (int corner = 0; corner < 3; ++corner) {
            expect_same_feature(soup, 3 * f + corner, welded, mesh.faces[at(f)][at(corner)], 1e-6);
        }
    }
}

// Lips that are closed in the reference and open in another shape are no seam.
TEST(Places, VerticesThatTouchInSomeShapesOnlyStayApart) {
    std::vector<TriangleMesh> meshes = moving(seamed());
    for (int ring = 2; ring < 5; ++ring) {
        meshes.back().vertices[at(ring * (kAround + 1) + kAround)][2] += 1e-3;
    }
    const PlacedFeatures set = extracted(meshes);
    EXPECT_EQ(set.places.coincident_count(), kRings - 3);
    EXPECT_NE(set.places.place(3 * (kAround + 1)), set.places.place(3 * (kAround + 1) + kAround));
    EXPECT_EQ(set.places.place(5 * (kAround + 1)), set.places.place(5 * (kAround + 1) + kAround));
}

// Three vertices on each other, of which two part, then another two: none is left.
TEST(Places, GroupsFallApartAsShapesSay) {
    TriangleMesh mesh = shapes::soup(shapes::icosphere(0));
    std::vector<TriangleMesh> meshes{mesh, mesh, mesh};
    std::vector<int> corner;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (square_distance(mesh.vertices[at(v)], mesh.vertices[0]) < 1e-20) corner.push_back(v);
    }
    ASSERT_EQ(corner.size(), 5u);
    for (int k = 0; k < 5; ++k) {
        meshes[1].vertices[at(corner[at(k)])][0] += k < 2 ? 0.1 : 0.0;
        meshes[2].vertices[at(corner[at(k)])][0] += k % 2 == 0 ? 0.1 : 0.0;
    }
    const VertexPlaces places = extracted(meshes).places;
    const auto place = [&](int k) { return places.place(corner[at(k)]); };
    EXPECT_EQ(place(2), place(4));  // in both beside each other
    EXPECT_NE(place(0), place(1));
    EXPECT_NE(place(0), place(2));
    EXPECT_NE(place(1), place(3));
    EXPECT_NE(place(2), place(3));
}

TEST(Places, AreKeptInTheFile) {
    const TemporaryFolder folder;
    const std::string path = folder / "seam.safetensors";
    const PlacedFeatures set = extracted(moving(seamed()));
    write_features(path, set, set.places);
    EXPECT_EQ(read_features(path).places.place_of_vertex(), set.places.place_of_vertex());
    const FeatureFile file(path);
    const SurfaceShapes surface(file, set.places);
    EXPECT_EQ(surface.vertex_count(), tube().vertex_count());
    EXPECT_EQ(surface.shape(1).size(), tube().vertices.size() * kFeatureDim);
    EXPECT_EQ(surface.vertices(1).size(), tube().vertices.size() * 3);
}

TriangleMesh with_far_vertex(TriangleMesh mesh, double x) {
    mesh.vertices.insert(mesh.vertices.begin() + 5, Point{x, -x, 2 * x});
    for (Face& face : mesh.faces) {
        for (int& corner : face) corner += corner >= 5 ? 1 : 0;
    }
    return mesh;
}

// The far vertex goes elsewhere in every shape: alignment, size and features do not see it.
TEST(Places, AFarVertexWithoutAFaceChangesNoFeature) {
    const std::vector<TriangleMesh> meshes = moving(bumpy_sphere(2));
    std::vector<TriangleMesh> with;
    for (std::size_t n = 0; n < meshes.size(); ++n) {
        with.push_back(with_far_vertex(meshes[n], 1e5 * (1 + 2.0 * static_cast<double>(n * n))));
    }
    const PlacedFeatures plain = extracted(meshes), set = extracted(with);
    EXPECT_EQ(set.places.unused_count(), 1);
    EXPECT_THAT(set.warnings, Contains(HasSubstr("1 vertices without faces get the identity and "
                                                 "have no part in alignment and scale (first: "
                                                 "vertex 6)")));
    for (int v = 0; v < plain.vertex_count(); ++v) {
        expect_same_feature(set, v < 5 ? v : v + 1, plain, v, 0);
    }
    for (int k = 0; k < kFeatureDim; ++k) {
        EXPECT_EQ(feature(set, 5, 1)[k], kReferenceFeature[at(k)]);
    }
    EXPECT_EQ(set.rotation, plain.rotation);
}

TEST(Places, AFarVertexWithoutAFaceWeldsNothing) {
    std::vector<TriangleMesh> with;
    for (const TriangleMesh& mesh : moving(bumpy_sphere(2))) {
        with.push_back(with_far_vertex(mesh, 1e9));
    }
    EXPECT_EQ(extracted(with).places.coincident_count(), 0);
}

// A map's coordinates: what float32 keeps of the shape is what it would keep at the origin,
// whatever lies at that of the map without a face.
TEST(Places, AReferenceFarFromTheOriginIsKeptNearIt) {
    for (const bool has_stray : {false, true}) {
        std::vector<TriangleMesh> far;
        for (const TriangleMesh& mesh : moving(bumpy_sphere(2))) {
            far.push_back(mapped(
                mesh, [](const Vector3d& p) -> Vector3d { return p + Vector3d(5e5, 5.5e6, 100); }));
            if (has_stray) far.back() = with_far_vertex(far.back(), 0);
        }
        for (const bool align : {true, false}) {
            const PlacedFeatures set = extract_features(sequence_of(far), far.front().vertices,
                                                        {EdgeWeights::cotangent, align});
            EXPECT_THAT(set.warnings, Contains(HasSubstr("everything is kept relative to (5")));
            for (int n = 0; n < set.shape_count(); ++n) {
                const Matrix3d rotation =
                    Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
                        set.rotation[at(n)].data());
                for (int v = 0; v < set.vertex_count(); ++v) {
                    if (set.places.place(v) < 0) continue;
                    const float* kept =
                        set.vertices.data() + 3 * (at(n) * at(set.vertex_count()) + at(v));
                    const Vector3d back =
                        rotation.transpose() *
                        (Vector3d(kept[0], kept[1], kept[2]) - vec(set.translation[at(n)]));
                    ASSERT_LT(largest(back - vec(far[at(n)].vertices[at(v)])), 1e-6);
                }
            }
        }
    }
}

}  // namespace
}  // namespace mscomp

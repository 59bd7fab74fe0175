// SPDX-License-Identifier: MIT
// Our readers against those of other libraries, on meshes clean enough for all of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "acap/mesh/polygon_mesh.h"
#include "mesh/generated_meshes.h"
#include "mesh/other_readers.h"

namespace mscomp {
namespace {

constexpr int kMeshCount = 500;
constexpr double kOpenMeshRounding = 6e-8;  // passes through float: 2^-24
constexpr double kTinyobjRounding =
    2e-15;  // adds up digits in double: a few units in the last place

OtherMesh ours(const PolygonMesh& mesh) {
    OtherMesh result{mesh.vertices, {}};
    for (std::size_t i = 0; i < mesh.face_count(); ++i) {
        result.faces.emplace_back(mesh.face(i).begin(), mesh.face(i).end());
    }
    return result;
}

/// Half-edge libraries may start a face anywhere.
void start_at_smallest_corner(std::vector<std::vector<int>>& faces) {
    for (std::vector<int>& face : faces) {
        std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    }
}

/// How far other libraries round: `tolerance` relative to the coordinate.
void expect_same(OtherMesh expected, OtherMesh got, double tolerance) {
    ASSERT_EQ(got.vertices.size(), expected.vertices.size());
    for (std::size_t i = 0; i < got.vertices.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = expected.vertices[i][k], y = got.vertices[i][k];
            ASSERT_TRUE(std::abs(x - y) <= tolerance * std::abs(x)) << x << " " << y << " " << i;
        }
    }
    start_at_smallest_corner(expected.faces);
    start_at_smallest_corner(got.faces);
    ASSERT_EQ(got.faces, expected.faces);
}

/// What the text says, as the standard library reads it.
std::vector<Point> as_spelled(std::vector<Point> vertices, int spelling) {
    for (Point& p : vertices) {
        for (double& x : p) x = std::strtod(number_text(x, spelling).c_str(), nullptr);
    }
    return vertices;
}

struct Case {
    int number = 0, spelling = 0;
    GeneratedMesh mesh;
    OtherMesh expected;
};

template <class Check>
void for_every_mesh(Check&& check) {
    for (int number = 0; number < kMeshCount; ++number) {
        SCOPED_TRACE(number);
        Case c{number, number / 5 % 5, generated_mesh(number), {}};
        c.expected = {as_spelled(c.mesh.vertices, c.spelling), c.mesh.faces};
        check(c);
        if (testing::Test::HasFatalFailure()) return;
    }
}

std::string obj_of(const Case& c) {
    return obj_text(c.mesh, c.spelling, static_cast<Corner>(c.number / 25 % 5));
}

TEST(GeneratedMeshes, AreReadAsTheyWereMade) {
    for_every_mesh([](const Case& c) {
        OtherMesh got = ours(parse_obj_polygons(obj_of(c), "a.obj"));
        EXPECT_EQ(got.vertices, c.expected.vertices);
        ASSERT_EQ(got.faces, c.expected.faces);
        got = ours(parse_off_polygons(off_text(c.mesh, c.spelling), "a.off"));
        EXPECT_EQ(got.vertices, c.expected.vertices);
        ASSERT_EQ(got.faces, c.expected.faces);
        got = ours(parse_ply_polygons(ply_text(c.mesh, c.spelling), "a.ply"));
        EXPECT_EQ(got.vertices, c.expected.vertices);
        ASSERT_EQ(got.faces, c.expected.faces);
        for (const bool big : {false, true}) {
            got = ours(parse_ply_polygons(ply_bytes(c.mesh, big), "a.ply"));
            EXPECT_EQ(got.vertices, c.mesh.vertices);
            ASSERT_EQ(got.faces, c.expected.faces);
        }
    });
}

TEST(ObjReader, AgreesWithOpenMesh) {
    for_every_mesh([](const Case& c) {
        const std::string text = obj_of(c);
        expect_same(ours(parse_obj_polygons(text, "a.obj")), read_with_openmesh(text, ".obj"),
                    kOpenMeshRounding);
    });
}

TEST(OffReader, AgreesWithOpenMesh) {
    for_every_mesh([](const Case& c) {
        const std::string text = off_text(c.mesh, c.spelling);
        expect_same(ours(parse_off_polygons(text, "a.off")), read_with_openmesh(text, ".off"),
                    kOpenMeshRounding);
    });
}

TEST(PlyReader, AgreesWithOpenMesh) {
    for_every_mesh([](const Case& c) {
        for (const std::string& bytes :
             {ply_text(c.mesh, c.spelling), ply_bytes(c.mesh, false), ply_bytes(c.mesh, true)}) {
            expect_same(ours(parse_ply_polygons(bytes, "a.ply")), read_with_openmesh(bytes, ".ply"),
                        kOpenMeshRounding);
        }
    });
}

#ifdef MSCOMP_WITH_TINYOBJLOADER
TEST(ObjReader, AgreesWithTinyobjloader) {
    for_every_mesh([](const Case& c) {
        const std::string text = obj_of(c);
        expect_same(ours(parse_obj_polygons(text, "a.obj")), read_with_tinyobjloader(text),
                    kTinyobjRounding);
    });
}
#endif

}  // namespace
}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/temporary_folder.h"
#include "base/thrown_message.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/error.h"
#include "mscomp/base/random.h"
#include "shapes.h"

namespace mscomp {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// Positions of every size a float has, the extremes among them.
TriangleMesh mesh_of_floats() {
    TriangleMesh mesh = shapes::icosphere(3);
    const CounterRandom random(2, 0);
    std::uint64_t draw = 0;
    for (Point& point : mesh.vertices) {
        for (double& x : point) {
            float value = 0;
            do {
                value = std::bit_cast<float>(static_cast<std::uint32_t>(random.bits(draw++)));
            } while (!std::isfinite(value));
            x = static_cast<double>(value);
        }
    }
    using Limits = std::numeric_limits<float>;
    mesh.vertices[0] = {Limits::max(), Limits::min(), Limits::denorm_min()};
    mesh.vertices[1] = {-0.0, static_cast<double>(1.0F / 3.0F), -Limits::max()};
    return mesh;
}

// Nine significant digits tell any two floats apart.
TEST(WriteObj, KeepsEveryFloatExactly) {
    const TemporaryFolder folder;
    const TriangleMesh mesh = mesh_of_floats();
    write_obj(folder / "a.obj", mesh);
    const TriangleMesh read = read_mesh(folder / "a.obj");
    ASSERT_EQ(read.vertex_count(), mesh.vertex_count());
    EXPECT_EQ(read.faces, mesh.faces);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(std::bit_cast<std::uint32_t>(static_cast<float>(read.vertices[i][axis])),
                      std::bit_cast<std::uint32_t>(static_cast<float>(mesh.vertices[i][axis])));
        }
    }
}

TEST(WriteOff, KeepsEveryFloatExactly) {
    const TemporaryFolder folder;
    const TriangleMesh mesh = mesh_of_floats();
    write_off(folder / "a.off", mesh);
    const TriangleMesh read = read_mesh(folder / "a.off");
    ASSERT_EQ(read.vertex_count(), mesh.vertex_count());
    EXPECT_EQ(read.faces, mesh.faces);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(std::bit_cast<std::uint32_t>(static_cast<float>(read.vertices[i][axis])),
                      std::bit_cast<std::uint32_t>(static_cast<float>(mesh.vertices[i][axis])));
        }
    }
}

TEST(WriteOff, WritesTheDocumentedText) {
    const TemporaryFolder folder;
    write_off(folder / "a.off", {{{1, 0, -2}, {0, 0.1, 0}, {0, 1e-9, 0}}, {{2, 0, 1}}});
    EXPECT_EQ(TemporaryFolder::content(folder / "a.off"),
              "OFF\n3 1 0\n1 0 -2\n0 0.1 0\n0 1e-09 0\n3 2 0 1\n");
}

// Each extension leads to the writer of that name.
TEST(WriteMesh, ChoosesTheWriterByTheExtension) {
    const TemporaryFolder folder;
    const TriangleMesh mesh = shapes::grid(3, 2);
    write_obj(folder / "1.obj", mesh);
    write_ply(folder / "1.ply", mesh);
    write_off(folder / "1.off", mesh);
    for (const char* extension : {".obj", ".ply", ".off"}) {
        const std::string path = folder / ("2" + std::string(extension));
        write_mesh(path, mesh);
        EXPECT_EQ(TemporaryFolder::content(path),
                  TemporaryFolder::content(folder / ("1" + std::string(extension))));
        EXPECT_EQ(read_mesh(path).vertices, mesh.vertices);
    }
    write_mesh(folder / "3.OBJ", mesh);
    EXPECT_EQ(read_mesh(folder / "3.OBJ").faces, mesh.faces);
    EXPECT_EQ(thrown_message<UsageError>([&] { write_mesh(folder / "a.stl", mesh); }),
              (folder / "a.stl") + ": got the extension '.stl', expected .obj, .ply or .off");
}

TEST(WritePly, KeepsEveryFloatExactly) {
    const TemporaryFolder folder;
    const TriangleMesh mesh = mesh_of_floats();
    write_ply(folder / "a.ply", mesh);
    const TriangleMesh read = read_mesh(folder / "a.ply");
    EXPECT_EQ(read.vertices, mesh.vertices);
    EXPECT_EQ(read.faces, mesh.faces);
}

TEST(WritePly, WithColorsAndQualityKeepsTheMesh) {
    const TemporaryFolder folder;
    const TriangleMesh mesh = mesh_of_floats();
    const std::vector<VertexColor> colors(mesh.vertices.size(), {1, 2, 3});
    const std::vector<float> quality(mesh.vertices.size(), 0.25F);
    write_ply(folder / "a.ply", mesh, colors, quality);
    EXPECT_EQ(read_mesh(folder / "a.ply").vertices, mesh.vertices);
    write_ply(folder / "b.ply", mesh, {}, quality);
    EXPECT_EQ(read_mesh(folder / "b.ply").vertices, mesh.vertices);
}

// The bytes the format asks for, written out by hand.
TEST(WritePly, WritesTheDocumentedBytes) {
    const TemporaryFolder folder;
    const TriangleMesh mesh{{{1, 0, -2}, {0, 0, 0}, {0, 1, 0}}, {{2, 0, 1}}};
    const std::vector<VertexColor> colors{{255, 128, 1}, {0, 0, 0}, {7, 8, 9}};
    const std::vector<float> quality{1, 0, 0.5F};
    write_ply(folder / "a.ply", mesh, colors, quality);
    const std::string one("\0\0\x80\x3f", 4), minus_two("\0\0\0\xc0", 4), half("\0\0\0\x3f", 4),
        zero(4, '\0');
    EXPECT_EQ(TemporaryFolder::content(folder / "a.ply"),
              "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty "
              "float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar "
              "blue\nproperty float quality\nelement face 1\nproperty list uchar int "
              "vertex_indices\nend_header\n" +
                  one + zero + minus_two + "\xff\x80\x01" + one +     //
                  zero + zero + zero + std::string(3, '\0') + zero +  //
                  zero + one + zero + "\x07\x08\x09" + half +         //
                  "\x03" + std::string("\2\0\0\0\0\0\0\0\1\0\0\0", 12));
}

TEST(Writers, RefusePositionsThatAreNotFinite) {
    const TemporaryFolder folder;
    TriangleMesh mesh = shapes::grid(2, 2);
    mesh.vertices[2][1] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THAT(thrown_message<NumericalError>([&] { write_obj(folder / "a.obj", mesh); }),
                HasSubstr("a.obj: vertex 3"));
    EXPECT_THROW(write_ply(folder / "a.ply", mesh), NumericalError);
    EXPECT_THROW(write_off(folder / "a.off", mesh), NumericalError);
    EXPECT_THAT(folder.names(), IsEmpty());
}

// Its positions are float32: what lies beyond would become infinity, which no reader takes.
TEST(Writers, RefuseInAPlyWhatIsBeyondFloat) {
    const TemporaryFolder folder;
    TriangleMesh mesh = shapes::grid(2, 2);
    mesh.vertices[2][1] = -1e39;
    EXPECT_THAT(thrown_message<NumericalError>([&] { write_ply(folder / "a.ply", mesh); }),
                HasSubstr("a.ply: vertex 3 (counting from 1) has a coordinate of -1e+39"));
    EXPECT_THAT(folder.names(), IsEmpty());
    mesh.vertices[2][1] = static_cast<double>(-std::numeric_limits<float>::max());
    write_ply(folder / "a.ply", mesh);
    EXPECT_EQ(read_mesh(folder / "a.ply").vertices[2][1], mesh.vertices[2][1]);
}

TEST(Writers, RefuseColorsOfAnotherCount) {
    const TemporaryFolder folder;
    const std::vector<float> quality(3);
    EXPECT_THROW(write_ply(folder / "a.ply", shapes::grid(2, 2), {}, quality), std::logic_error);
}

double largest_difference(const std::vector<Point>& a, const std::vector<Point>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            largest = std::max(largest, std::abs(a[i][axis] - b[i][axis]));
        }
    }
    return largest;
}

// Seven digits of the size survive wherever the mesh lies, and as_written() says which.
TEST(WriteMesh, KeepsTheShapeFarFromTheOrigin) {
    const TemporaryFolder folder;
    for (const double place : {0.0, 3.0, 5e2, 1e4, 2e7}) {
        TriangleMesh mesh = shapes::icosphere(2);
        for (Point& p : mesh.vertices) p = {p[0] / 3 + place, p[1] / 3 - place, p[2] / 3};
        for (const char* name : {"a.obj", "a.off", "a.ply"}) {
            write_mesh(folder / name, mesh);
            const std::vector<Point> read = read_mesh(folder / name).vertices;
            EXPECT_EQ(read, as_written(folder / name, mesh)) << name << " at " << place;
            EXPECT_LT(largest_difference(read, mesh.vertices), 1e-5) << name << " at " << place;
        }
    }
}

// What no face uses may lie anywhere.
TEST(WriteMesh, AFarVertexWithoutAFaceTakesNoDigits) {
    const TemporaryFolder folder;
    TriangleMesh mesh = shapes::icosphere(2);
    for (Point& p : mesh.vertices) p[0] = p[0] / 3 + 2e7;
    mesh.vertices.push_back({0, 0, 0});
    for (const char* name : {"a.obj", "a.off", "a.ply"}) {
        write_mesh(folder / name, mesh);
        const std::vector<Point> read = read_mesh(folder / name).vertices;
        EXPECT_LT(largest_difference(read, mesh.vertices), 1e-5) << name;
    }
}

}  // namespace
}  // namespace mscomp

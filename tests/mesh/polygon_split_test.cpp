// SPDX-License-Identifier: MIT
#include "acap/mesh/polygon_split.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>

#include "base/temporary_folder.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/acap/mesh/shape_source.h"
#include "mscomp/base/random.h"

namespace mscomp {
namespace {

PolygonMesh polygon(std::vector<Point> points, std::vector<int> corners) {
    PolygonMesh mesh;
    mesh.vertices = std::move(points);
    mesh.ends = {corners.size()};
    mesh.corners = std::move(corners);
    return mesh;
}

std::vector<int> ascending(std::size_t count) {
    std::vector<int> corners(count);
    std::iota(corners.begin(), corners.end(), 0);
    return corners;
}

/// Signed, seen along z.
double area(const std::vector<Point>& p, const Face& f) {
    const Point &a = p[at(f[0])], &b = p[at(f[1])], &c = p[at(f[2])];
    return 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]));
}

double total_area(const std::vector<Point>& p, const std::vector<Face>& faces) {
    double sum = 0;
    for (const Face& face : faces) sum += area(p, face);
    return sum;
}

/// A contour of `count` corners that a ray from the origin meets once, with deep bays.
std::vector<Point> star(int count, std::uint64_t seed) {
    const CounterRandom random(seed, 0);
    std::vector<Point> points;
    for (int i = 0; i < count; ++i) {
        const double angle = 2 * std::numbers::pi * i / count;
        const double radius = 0.1 + random.uniform(static_cast<std::uint64_t>(i));
        points.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
    }
    return points;
}

using Triangles = std::set<std::set<int>>;
Triangles as_sets(const std::vector<Face>& faces) {
    Triangles sets;
    for (const Face& face : faces) sets.insert({face[0], face[1], face[2]});
    return sets;
}

TEST(PolygonSplit, TrianglesStayAsTheyAre) {
    const PolygonMesh mesh = polygon({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {2, 0, 1});
    EXPECT_EQ(split_into_triangles(mesh, mesh.vertices).faces, std::vector<Face>({{2, 0, 1}}));
}

// Triangles of a triangulation all turn as the polygon does and fill its area exactly once.
TEST(PolygonSplit, OfConcavePolygonsCoversThemOnce) {
    for (const int count : {4, 5, 6, 7, 11, 40, 333}) {
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            const PolygonMesh mesh = polygon(star(count, seed), ascending(at(count)));
            const std::vector<Face> faces = split_into_triangles(mesh, mesh.vertices).faces;
            ASSERT_EQ(faces.size(), at(count - 2));
            double contour = 0;
            for (int i = 0; i < count; ++i) {
                const Point &a = mesh.vertices[at(i)], &b = mesh.vertices[at((i + 1) % count)];
                contour += 0.5 * (a[0] * b[1] - a[1] * b[0]);
            }
            EXPECT_NEAR(total_area(mesh.vertices, faces), contour, 1e-12);
            for (const Face& face : faces) EXPECT_GT(area(mesh.vertices, face), 0) << count;
        }
    }
}

// Wherever it begins, and read backwards: the same triangles, forwards as the same rows.
TEST(PolygonSplit, DoesNotDependOnTheFirstCornerOrTheDirection) {
    for (const int count : {4, 5, 9, 30}) {
        for (std::uint64_t seed = 0; seed < 10; ++seed) {
            std::vector<int> corners = CounterRandom(seed, 1).permutation(count);
            std::vector<Point> points(at(count));
            const std::vector<Point> contour = star(count, seed);
            for (std::size_t i = 0; i < contour.size(); ++i) {
                points[at(corners[i])] = {contour[i][0], 0.3 * contour[i][0], contour[i][1]};
            }
            const std::vector<Face> wanted =
                split_into_triangles(polygon(points, corners), points).faces;
            for (int start = 1; start < count; ++start) {
                std::rotate(corners.begin(), corners.begin() + 1, corners.end());
                EXPECT_EQ(split_into_triangles(polygon(points, corners), points).faces, wanted);
            }
            std::reverse(corners.begin(), corners.end());
            EXPECT_EQ(as_sets(split_into_triangles(polygon(points, corners), points).faces),
                      as_sets(wanted));
        }
    }
}

// What was a fan from the first corner is the same rows still where that is the lowest one.
TEST(PolygonSplit, OfConvexPolygonsIsTheFanOfTheLowestCorner) {
    std::vector<Point> points;
    for (int i = 0; i < 7; ++i) points.push_back({std::cos(0.8 * i), std::sin(0.8 * i), 1});
    std::vector<int> corners = ascending(7);
    std::vector<Face> fan;
    for (int i = 2; i < 7; ++i) fan.push_back({0, i - 1, i});
    EXPECT_EQ(split_into_triangles(polygon(points, corners), points).faces, fan);
    const PolygonMesh quad = polygon({{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}}, {0, 2, 3, 1});
    EXPECT_EQ(split_into_triangles(quad, quad.vertices).faces,
              (std::vector<Face>{{0, 2, 3}, {0, 3, 1}}));
}

TEST(PolygonSplit, OfAConcaveQuadGoesThroughItsHollowCorner) {
    const std::vector<Point> arrow{{0, 0, 0}, {1, 1, 0}, {0, 3, 0}, {-1, 1, 0}};
    const auto split = [](std::vector<Point> points) {
        const PolygonMesh mesh = polygon(std::move(points), ascending(4));
        return as_sets(split_into_triangles(mesh, mesh.vertices).faces);
    };
    std::vector<Point> hollow = arrow;
    hollow[2][1] = 0.5;  // corner 2 lies behind the line from 1 to 3
    EXPECT_EQ(split(hollow), (Triangles{{0, 1, 2}, {0, 2, 3}}));
    hollow = {arrow[3], arrow[0], arrow[1], {0, 0.5, 0}};
    EXPECT_EQ(split(hollow), (Triangles{{0, 1, 3}, {1, 2, 3}}));
}

// A corner on a straight side, as where a neighbour is split.
TEST(PolygonSplit, MakesNoTriangleWithoutAreaWhereItNeedNot) {
    const PolygonMesh quad = polygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}}, ascending(4));
    for (const Face& face : split_into_triangles(quad, quad.vertices).faces) {
        EXPECT_GT(area(quad.vertices, face), 0.1);
    }
    const PolygonMesh five =
        polygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}, ascending(5));
    for (const Face& face : split_into_triangles(five, five.vertices).faces) {
        EXPECT_GT(area(five.vertices, face), 0.1);
    }
}

// No area, a contour that crosses itself, corners twice, coordinates beyond computing: still F - 2
// triangles of the polygon's own corners.
TEST(PolygonSplit, OfWhatIsNoPolygonIsDefined) {
    const std::vector<Point> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}};
    EXPECT_EQ(split_into_triangles(polygon(line, ascending(5)), line).faces,
              (std::vector<Face>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
    const std::vector<Point> eight{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0.5, 0}};
    const double huge = 1e300;
    const std::vector<Point> beyond{
        {0, 0, 0}, {huge, 0, 0}, {huge, huge, 0}, {0, huge, 0}, {-huge, 1, 0}};
    for (const auto& points : {line, eight, beyond}) {
        for (const std::vector<int>& corners :
             {std::vector<int>{3, 1, 4, 0, 2}, {0, 0, 1, 1, 2}, {4, 4, 4, 4, 4}, {0, 1, 2, 0, 1}}) {
            EXPECT_EQ(split_into_triangles(polygon(points, corners), points).faces.size(), 3u);
        }
    }
}

// The file counts faces that are left out, too.
TEST(PolygonSplit, KnowsTheFacesOfTheFile) {
    PolygonMesh mesh = polygon({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {0, 1, 2, 3});
    mesh.small_faces = {0, 1, 1};
    mesh.corners.insert(mesh.corners.end(), {0, 1, 2});
    mesh.ends.push_back(7);
    EXPECT_THAT(split_into_triangles(mesh, mesh.vertices).face_numbers,
                testing::ElementsAre(2, 2, 5));
}

// The shape that is the reference decides, not the first file.
TEST(MeshFiles, SplitPolygonsAsTheReferenceWantsIt) {
    const TemporaryFolder folder;
    const std::string face = "f 1 2 3 4\n";
    const std::string square = folder.put("1.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n" + face);
    const std::string arrow = folder.put("2.obj", "v 0 1 0\nv 1 0 0\nv 0 3 0\nv -1 0 0\n" + face);
    const std::string other = folder.put("3.obj", "v 0 2 0\nv 1 0 0\nv 0 3 0\nv -1 0 0\n" + face);
    const std::vector<std::string> paths{square, arrow, other};
    EXPECT_EQ(as_sets(MeshFiles(paths).faces()), (Triangles{{0, 1, 2}, {0, 2, 3}}));
    const std::string hollow = folder.put("4.obj", "v -1 0 0\nv 0 1 0\nv 1 0 0\nv 0 3 0\n" + face);
    EXPECT_EQ(as_sets(MeshFiles({square, hollow}, 1).faces()), (Triangles{{0, 1, 3}, {1, 2, 3}}));
}

// Of a polygon nothing but the polygon is duplicate or degenerate.
TEST(MeshFiles, FacesOfReportsAreThoseOfTheFile) {
    const TemporaryFolder folder;
    const std::string path = folder.put(
        "a.obj",
        "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nv 0 2 0\nf 1 2 3 4 5\nf 1 2\nf 3 4 5 1 2\n");
    const MeshFiles files({path});
    const ConnectivityReport report =
        analyze_connectivity(files.vertex_count(), files.faces(), files.face_numbers()).report;
    EXPECT_EQ(report.duplicate_faces, 1);
    EXPECT_THAT(report.warnings, testing::Contains("1 face has the vertices of an earlier one, the "
                                                   "first is face 3, as face 1"));
}

}  // namespace
}  // namespace mscomp

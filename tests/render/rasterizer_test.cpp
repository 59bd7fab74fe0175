// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "mscomp/render/render.h"
#include "shapes.h"

namespace mscomp {
namespace {

using Color = std::array<float, 3>;

/// Shows x and y from -1 to 1, y up.
const View kFrontView;

std::array<int, 3> pixel(const Image& image, int x, int y) {
    const auto at = static_cast<std::size_t>(y * image.width + x) * 3;
    return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
}

bool is_background(const std::array<int, 3>& color) {
    return color == std::array<int, 3>{255, 255, 255};
}

/// Black shape on white: how much of the picture is covered, in pixels.
double covered(const Image& image) {
    double sum = 0;
    for (std::size_t i = 0; i < image.rgb.size(); i += 3) sum += 1 - image.rgb[i] / 255.0;
    return sum;
}

TriangleMesh triangle(double z) {
    return {{{-0.6, -0.5, z}, {0.7, -0.5, z}, {-0.1, 0.6, z}}, {{0, 1, 2}}};
}

std::vector<Color> all(const TriangleMesh& mesh, const Color& color) {
    return std::vector<Color>(mesh.vertices.size(), color);
}

const Color kBlack{0, 0, 0}, kRedVertex{1, 0, 0}, kBlueVertex{0, 0, 1};

// Coverage with anti-aliasing is the area: 1.3 * 1.1 / 2 of 4 square units in 200 x 200 pixels.
TEST(Rasterizer, CoversTheAreaOfATriangle) {
    const TriangleMesh mesh = triangle(0);
    const Image image = render_mesh(mesh, all(mesh, kBlack), kFrontView, 200, 200);
    const double truth = 0.5 * 1.3 * 1.1 / 4 * 200 * 200;
    EXPECT_NEAR(covered(image) / truth, 1, 0.003);
}

TEST(Rasterizer, PutsPointsWhereTheViewSays) {
    // A small square around (0.5, 0.25): column 150 and row 75 of 200.
    const TriangleMesh mesh{{{0.46, 0.21, 0}, {0.54, 0.21, 0}, {0.54, 0.29, 0}, {0.46, 0.29, 0}},
                            {{0, 1, 2}, {0, 2, 3}}};
    const Image image = render_mesh(mesh, all(mesh, kBlack), kFrontView, 200, 200);
    EXPECT_EQ(pixel(image, 150, 75), (std::array<int, 3>{0, 0, 0}));
    for (const auto& [x, y] : {std::pair{140, 75}, {160, 75}, {150, 65}, {150, 85}, {50, 125}}) {
        EXPECT_TRUE(is_background(pixel(image, x, y))) << x << ", " << y;
    }
}

// In a wide picture the view fills the height, centred.
TEST(Rasterizer, FitsTheNearerEdge) {
    const TriangleMesh mesh{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}},
                            {{0, 1, 2}, {0, 2, 3}}};
    const Image image = render_mesh(mesh, all(mesh, kBlack), kFrontView, 300, 100);
    EXPECT_NEAR(covered(image), 100 * 100, 1);
    EXPECT_TRUE(is_background(pixel(image, 98, 50)));
    EXPECT_FALSE(is_background(pixel(image, 101, 50)));
}

// The edge two triangles share is covered once: no gap shows the background.
TEST(Rasterizer, LeavesNoGapBetweenTriangles) {
    TriangleMesh mesh = shapes::grid(14, 11);
    for (Point& p : mesh.vertices) p = {p[0] / 6.5 - 1 + 0.03 * std::sin(p[1]), p[1] / 5 - 1, 0};
    const Image image = render_mesh(mesh, all(mesh, kBlack), kFrontView, 90, 90);
    for (int y = 10; y < 80; ++y) {
        for (int x = 10; x < 80; ++x) EXPECT_EQ(pixel(image, x, y)[0], 0) << x << ", " << y;
    }
}

TEST(Rasterizer, ShowsTheNearerFace) {
    for (const double red_depth : {-0.4, 0.4}) {
        TriangleMesh mesh = triangle(red_depth);
        std::vector<Color> colors = all(mesh, kRedVertex);
        const TriangleMesh other = triangle(0);
        mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
        mesh.faces.push_back({3, 4, 5});
        for (int i = 0; i < 3; ++i) colors.push_back(kBlueVertex);
        const Image image = render_mesh(mesh, colors, kFrontView, 60, 60);
        const std::array<int, 3> seen = pixel(image, 30, 30);
        // The viewer is at +z: what lies higher is nearer.
        EXPECT_EQ(seen[0] > seen[2], red_depth > 0) << "red at " << red_depth;
        EXPECT_TRUE(seen[0] == 0 || seen[2] == 0);
    }
}

// A plane that is cut by another shows either on its own side of the cut.
TEST(Rasterizer, ResolvesDepthWithinFaces) {
    const TriangleMesh mesh{{{-1, -1, -1},
                             {1, -1, 1},
                             {1, 1, 1},
                             {-1, 1, -1},  // rises along x
                             {-1, -1, 0},
                             {1, -1, 0},
                             {1, 1, 0},
                             {-1, 1, 0}},
                            {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}}};
    std::vector<Color> colors(8, kRedVertex);
    for (std::size_t i = 4; i < 8; ++i) colors[i] = kBlueVertex;
    const Image image = render_mesh(mesh, colors, kFrontView, 60, 60);
    EXPECT_EQ(pixel(image, 45, 20)[2], 0) << "red in front on the right";
    EXPECT_EQ(pixel(image, 15, 20)[0], 0) << "blue in front on the left";
}

TEST(Rasterizer, SmoothsEdges) {
    const TriangleMesh mesh = triangle(0);
    const Image image = render_mesh(mesh, all(mesh, kBlack), kFrontView, 100, 100);
    int between = 0;
    for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
        between += image.rgb[i] > 0 && image.rgb[i] < 255;
    }
    // The outline is about 180 pixels long.
    EXPECT_GT(between, 80);
    EXPECT_LT(between, 400);
}

TEST(Rasterizer, ShowsColorsAndTheirBlend) {
    const TriangleMesh mesh = triangle(0);
    const std::vector<Color> colors{kRedVertex, kBlueVertex, kBlueVertex};
    const Image image = render_mesh(mesh, colors, kFrontView, 100, 100);
    const std::array<int, 3> left = pixel(image, 25, 70), right = pixel(image, 75, 70);
    EXPECT_GT(left[0], left[2]);
    EXPECT_GT(right[2], right[0]);
    EXPECT_GT(right[0], 0) << "a blend";
    EXPECT_EQ(left[1], 0);
}

// Two-sided: turning a face around changes nothing.
TEST(Rasterizer, ShadesBothSidesAlike) {
    TriangleMesh mesh = triangle(0);
    const Image front = render_mesh(mesh, {}, kFrontView, 50, 50);
    std::swap(mesh.faces[0][1], mesh.faces[0][2]);
    EXPECT_EQ(render_mesh(mesh, {}, kFrontView, 50, 50).rgb, front.rgb);
}

// The key light is at the upper left; nothing visible is black or as white as the background.
TEST(Rasterizer, LightsFromTheUpperLeft) {
    const Image image = render_mesh(shapes::icosphere(4), {}, kFrontView, 200, 200);
    EXPECT_GT(pixel(image, 65, 65)[0], pixel(image, 100, 100)[0]);
    EXPECT_GT(pixel(image, 100, 100)[0], pixel(image, 140, 160)[0] + 20);
    EXPECT_GT(pixel(image, 140, 160)[0], 60);
    EXPECT_GT(pixel(image, 100, 100)[0], 180) << "a white surface looks white";
}

// Smooth normals: on a sphere neighbouring pixels differ little although its faces are flat.
TEST(Rasterizer, ShadesSmoothly) {
    const Image image = render_mesh(shapes::icosphere(2), {}, kFrontView, 200, 200);
    for (int x = 60; x < 140; ++x) {
        EXPECT_LE(std::abs(pixel(image, x, 100)[0] - pixel(image, x + 1, 100)[0]), 4) << x;
    }
}

TEST(Rasterizer, DrawsTheSameForAnyNumberOfThreads) {
    const TriangleMesh mesh = shapes::icosphere(3);
    set_thread_count(1);
    const Image truth = render_mesh(mesh, {}, fit_view(mesh.vertices), 123, 77);
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        EXPECT_EQ(render_mesh(mesh, {}, fit_view(mesh.vertices), 123, 77).rgb, truth.rgb);
    }
    set_thread_count(0);
}

TEST(Rasterizer, CutsOffWhatIsOutside) {
    TriangleMesh mesh = triangle(0);
    for (Point& p : mesh.vertices) p = {100 * p[0], 100 * p[1], 0};
    mesh.vertices.push_back({1e5, 1e5, 0});
    mesh.faces.push_back({0, 1, 3});
    const Image image = render_mesh(mesh, all(mesh, kBlack), kFrontView, 40, 30);
    EXPECT_EQ(covered(image), 40 * 30);
}

TEST(Rasterizer, RefusesWhatCannotBeDrawn) {
    const TriangleMesh mesh = triangle(0);
    EXPECT_THROW(render_mesh(TriangleMesh{}, {}, kFrontView, 10, 10), MeshError);
    EXPECT_THROW(render_mesh(mesh, {}, kFrontView, 0, 10), UsageError);
    EXPECT_THROW(render_mesh(mesh, std::vector<Color>(2, kRedVertex), kFrontView, 10, 10),
                 MeshError);
    TriangleMesh broken = mesh;
    broken.vertices[1][2] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(render_mesh(broken, {}, kFrontView, 10, 10), MeshError);
    broken = mesh;
    broken.faces[0][0] = 3;
    EXPECT_THROW(render_mesh(broken, {}, kFrontView, 10, 10), MeshError);
}

TEST(WhiteToBlue, RunsFromWhiteToBlue) {
    EXPECT_EQ(white_to_blue(0), (Color{1, 1, 1}));
    EXPECT_EQ(white_to_blue(-1), white_to_blue(0));
    EXPECT_EQ(white_to_blue(2), white_to_blue(1));
    EXPECT_EQ(white_to_blue(std::numeric_limits<float>::quiet_NaN()), white_to_blue(0));
    const Color blue = white_to_blue(1), half = white_to_blue(0.5F);
    EXPECT_LT(blue[0], 0.3F);
    EXPECT_GT(blue[2], 0.8F);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(half[c], (1 + blue[c]) / 2, 1e-6);
}

}  // namespace
}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/render/viewpoint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mscomp/base/error.h"
#include "mscomp/base/points.h"
#include "shapes.h"

namespace mscomp {
namespace {

const Stance kUsual{{0, 1, 0}, {0, 0, 1}};

TEST(Viewpoint, SidesAreThoseOfAViewerOfTheFront) {
    const auto towards_viewer = [](const char* name) {
        return axes_from(kUsual, parse_viewpoint(name))[2];
    };
    const auto near = [](const Point& p, const Point& q) { return square_distance(p, q) < 1e-20; };
    EXPECT_TRUE(near(towards_viewer("front"), {0, 0, 1}));
    EXPECT_TRUE(near(towards_viewer("back"), {0, 0, -1}));
    EXPECT_TRUE(near(towards_viewer("right"), {1, 0, 0}));
    EXPECT_TRUE(near(towards_viewer("left"), {-1, 0, 0}));
    EXPECT_TRUE(near(towards_viewer("top"), {0, 1, 0}));
    EXPECT_TRUE(near(towards_viewer("bottom"), {0, -1, 0}));
    EXPECT_TRUE(near(towards_viewer("30,0"), {0.5, 0, std::sqrt(0.75)}));
    EXPECT_TRUE(near(towards_viewer("0,30"), {0, 0.5, std::sqrt(0.75)}));
}

TEST(Viewpoint, AxesAreOrthonormalAndUpIsUp) {
    for (const char* name : {"front", "left", "top", "bottom", "200,-45"}) {
        const auto axes = axes_from(kUsual, parse_viewpoint(name));
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                EXPECT_NEAR(dot(axes[i], axes[j]), i == j ? 1 : 0, 1e-12);
            }
        }
        EXPECT_NEAR(dot(cross(axes[0], axes[1]), axes[2]), 1, 1e-12);
        EXPECT_GE(axes[1][1], -1e-12) << name;
    }
}

TEST(Viewpoint, UpIsTheAxisAskedFor) {
    const std::vector<Point> box{{0, 0, 0}, {3, 1, 2}};
    for (const char* name : {"x", "y", "z", "-x", "-y", "-z"}) {
        const Point up = parse_axis(name);
        const auto axes = axes_from(stance_of(box, up), Viewpoint{});
        EXPECT_NEAR(dot(axes[1], up), 1, 1e-12) << name;
        EXPECT_EQ(axis_name(up), name[0] == '-' ? name : std::string("+") + name);
    }
    EXPECT_EQ(axis_name({0.6, 0.8, 0}), "(0.6, 0.8, 0)");
}

// The plate lies in the plane of x and y; turned over it looks the other way. A sphere has no open
// side; nor has a floor whose open side is up.
TEST(Viewpoint, OpenSurfacesFaceTheirFront) {
    TriangleMesh plate{{{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {0, 3, 0}}, {{0, 1, 2}, {0, 2, 3}}};
    Stance stance{{0, 1, 0}, {1, 0, 0}};
    EXPECT_TRUE(face_open_front(plate, stance));
    EXPECT_EQ(stance.front, (Point{0, 0, 1}));
    plate.faces = {{0, 2, 1}, {0, 3, 2}};
    EXPECT_TRUE(face_open_front(plate, stance));
    EXPECT_EQ(stance.front, (Point{0, 0, -1}));
    stance = {{0, 0, -1}, {1, 0, 0}};
    EXPECT_FALSE(face_open_front(plate, stance));
    EXPECT_FALSE(face_open_front(shapes::icosphere(2), stance));
    EXPECT_EQ(stance.front, (Point{1, 0, 0}));
}

TEST(Viewpoint, NamesSidesInWords) {
    EXPECT_EQ(name_of({0, 10}), "front");
    EXPECT_EQ(name_of({360, 0}), "front");
    EXPECT_EQ(name_of({-90, 0}), "left");
    EXPECT_EQ(name_of({135, 10}), "back right");
    EXPECT_EQ(name_of({180, 60}), "above, back");
    EXPECT_EQ(name_of({270, -45}), "below, left");
    EXPECT_EQ(name_of({0, 90}), "above");
}

TEST(Viewpoint, RefusesWhatIsNoDirection) {
    for (const char* text : {"", "w", "-", "xy", "--x", "+x", "X"}) {
        EXPECT_THROW(parse_axis(text), UsageError) << text;
    }
    for (const char* text : {"", "side", "30", "30,", ",10", "30,91", "nan,0", "0,inf", "361,0"}) {
        EXPECT_THROW(parse_viewpoint(text), UsageError) << text;
    }
}

}  // namespace
}  // namespace mscomp

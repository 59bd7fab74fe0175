// SPDX-License-Identifier: MIT
#include "mscomp/render/error_sheet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mscomp/base/error.h"
#include "shapes.h"

namespace mscomp {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

const TriangleMesh kBall = shapes::icosphere(3);

/// Ball with a dent of this depth where y, which is up, is above 0.3.
ComparedShape dented(double depth) {
    ComparedShape shape{"ball", "dented", kBall.vertices, kBall.vertices, {}};
    for (Point& p : shape.result) {
        shape.distance.push_back(p[1] > 0.3 ? depth : 0);
        p[1] -= shape.distance.back();
    }
    return shape;
}

Image sheet_of(const std::vector<ComparedShape>& shapes, int columns = 3) {
    return error_sheet(kBall, shapes, "", 100, columns);
}

/// How blue each pixel column is: the sum of blue minus red over its rows.
std::vector<int> blue_by_column(const Image& image) {
    std::vector<int> sums(static_cast<std::size_t>(image.width));
    for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
        sums[i / 3 % sums.size()] += image.rgb[i + 2] - image.rgb[i];
    }
    return sums;
}

int blue(const Image& image, double from, double to) {
    const std::vector<int> sums = blue_by_column(image);
    const auto at = [&](double share) {
        return sums.begin() + static_cast<long>(share * static_cast<double>(sums.size()));
    };
    int sum = 0;
    for (auto it = at(from); it != at(to); ++it) sum += *it;
    return sum;
}

TEST(ErrorSheet, ColoursTheResultOnly) {
    const Image sheet = sheet_of({dented(0.3)});
    EXPECT_EQ(blue(sheet, 0, 0.5), 0) << "the truth";
    EXPECT_GT(blue(sheet, 0.5, 1), 10000) << "the result";
}

TEST(ErrorSheet, OfPerfectResultsIsWithoutColour) {
    EXPECT_EQ(blue(sheet_of({dented(0)}), 0, 1), 0);
}

// One scale for all: half the distance is paler beside the whole, but as blue alone.
TEST(ErrorSheet, HasOneScaleForAllShapes) {
    const Image both = sheet_of({dented(0.3), dented(0.15)});
    const int whole = blue(both, 0.25, 0.5), half = blue(both, 0.75, 1);
    EXPECT_LT(half, 0.7 * whole);
    EXPECT_GT(half, 0.3 * whole);
    EXPECT_GT(blue(sheet_of({dented(0.15)}), 0.5, 1), 0.9 * blue(sheet_of({dented(0.3)}), 0.5, 1));
}

// Distances alone changed, by a power of ten: the same picture under another number.
TEST(ErrorSheet, PrintsTheLargestDistance) {
    ComparedShape shape = dented(0.3);
    const Image before = sheet_of({shape});
    for (double& distance : shape.distance) distance *= 10;
    const Image after = sheet_of({shape});
    ASSERT_EQ(after.rgb.size(), before.rgb.size());
    int lowest = -1;
    for (std::size_t i = 0; i < before.rgb.size(); ++i) {
        if (before.rgb[i] != after.rgb[i]) {
            lowest = static_cast<int>(i / 3 / static_cast<std::size_t>(before.width));
        }
    }
    EXPECT_GT(lowest, 0) << "the number is not there";
    EXPECT_LT(lowest, 28 + 26) << "something below the heading changed";
    EXPECT_EQ(largest_distance(std::vector{dented(0.3), dented(0.7)}), 0.7);
}

// A pair is never torn apart.
TEST(ErrorSheet, PutsPairsIntoRows) {
    const std::vector<ComparedShape> three{dented(0.1), dented(0.2), dented(0.3)};
    const Image one = sheet_of(three, 1), two = sheet_of(three, 2), wide = sheet_of(three, 3);
    EXPECT_EQ(one.width, sheet_of({dented(0.1)}).width);
    EXPECT_GT(one.height, two.height);
    EXPECT_GT(two.height, wide.height);
    EXPECT_GT(wide.width, two.width);
    EXPECT_EQ(blue(one, 0, 0.5), 0);
}

// The view holds every shape, also one that reaches far out.
TEST(ErrorSheet, ShowsShapesWhole) {
    ComparedShape far = dented(0);
    for (Point& p : far.result) p[0] *= 4;
    const Image sheet = sheet_of({far});
    // The outermost pixels of the pictures are background: nothing is cut off.
    const auto is_white = [&](int x, int y) {
        return sheet.rgb[static_cast<std::size_t>(y * sheet.width + x) * 3] == 255;
    };
    for (int y = 80; y < sheet.height - 60; ++y) {
        EXPECT_TRUE(is_white(28, y) && is_white(sheet.width - 29, y)) << y;
    }
}

TEST(ErrorSheet, TakesResultsThatAreNotFinite) {
    ComparedShape broken = dented(0.2);
    broken.result[5][1] = kNaN;
    broken.distance.assign(broken.distance.size(), kNaN);
    const Image sheet = sheet_of({broken, dented(0.2)});
    EXPECT_EQ(blue(sheet, 0, 0.5), 0);
    EXPECT_GT(blue(sheet, 0.75, 1), 10000);
    EXPECT_EQ(largest_distance(std::vector{broken}), 0);
    ComparedShape odd = dented(0.2);
    odd.distance[3] = kNaN;
    odd.distance[4] = std::numeric_limits<double>::infinity();
    EXPECT_EQ(largest_distance(std::vector{odd}), 0.2);
    EXPECT_NO_THROW(sheet_of({odd}));
}

TEST(ErrorSheet, RefusesWhatDoesNotFit) {
    EXPECT_THROW(sheet_of({}), UsageError);
    EXPECT_THROW(sheet_of({dented(0.1)}, 0), UsageError);
    ComparedShape shape = dented(0.1);
    shape.distance.pop_back();
    EXPECT_THROW(sheet_of({shape}), UsageError);
    shape = dented(0.1);
    shape.result.pop_back();
    EXPECT_THROW(sheet_of({shape}), UsageError);
    shape = dented(0.1);
    shape.truth.pop_back();
    EXPECT_THROW(sheet_of({shape}), UsageError);
    shape = dented(0.1);
    shape.truth[0][0] = kNaN;
    EXPECT_THROW(sheet_of({shape}), MeshError);
}

}  // namespace
}  // namespace mscomp

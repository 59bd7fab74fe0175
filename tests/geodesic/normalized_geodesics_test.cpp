// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mscomp/base/error.h"
#include "mscomp/geodesic/heat_geodesics.h"
#include "shapes.h"

namespace mscomp {
namespace {

// The farthest point on the unit sphere is the antipode, pi away.
TEST(GeodesicNormalizer, IsPiOnTheUnitSphere) {
    const GeodesicNormalizer normalizer = geodesic_normalizer(HeatGeodesics(shapes::icosphere(3)));
    EXPECT_TRUE(normalizer.exact);
    EXPECT_NEAR(normalizer.largest_distance, std::numbers::pi, 0.05 * std::numbers::pi);
}

// The longest distance in a rectangle is its diagonal.
TEST(GeodesicNormalizer, IsTheDiagonalOfARectangle) {
    const GeodesicNormalizer normalizer = geodesic_normalizer(HeatGeodesics(shapes::grid(31, 41)));
    EXPECT_NEAR(normalizer.largest_distance, 50, 1.5);
}

// Exact means: the largest entry of all rows.
TEST(GeodesicNormalizer, IsTheLargestEntryOfAllRows) {
    const HeatGeodesics geodesics(shapes::cylinder(9, 8, 1, 4, true));
    double largest = 0;
    for (int i = 0; i < geodesics.vertex_count(); ++i) {
        const std::vector<double> row = geodesics.distances(i);
        largest = std::max(largest, *std::max_element(row.begin(), row.end()));
    }
    EXPECT_EQ(geodesic_normalizer(geodesics).largest_distance, largest);
}

// Sweeps never exceed the exact value, and come close to it.
TEST(GeodesicNormalizer, SweepsBoundItFromBelow) {
    for (const TriangleMesh& mesh :
         {shapes::icosphere(3), shapes::grid(31, 41), shapes::cylinder(20, 30, 1, 6, true)}) {
        const HeatGeodesics geodesics(mesh);
        const double exact = geodesic_normalizer(geodesics).largest_distance;
        const GeodesicNormalizer swept = geodesic_normalizer(geodesics, 10);
        EXPECT_FALSE(swept.exact);
        EXPECT_LE(swept.largest_distance, exact);
        EXPECT_GE(swept.largest_distance, 0.95 * exact);
    }
}

// With several components it is the largest of their own, and never infinite.
TEST(GeodesicNormalizer, LooksInsideComponents) {
    TriangleMesh mesh = shapes::grid(4, 4);
    const TriangleMesh longer = shapes::grid(40, 3);
    for (const Point& p : longer.vertices) mesh.vertices.push_back({p[0], p[1], 5});
    for (const Face& f : longer.faces) mesh.faces.push_back({f[0] + 16, f[1] + 16, f[2] + 16});
    mesh.vertices.push_back({0, 0, 99});
    const HeatGeodesics geodesics(mesh);
    EXPECT_NEAR(geodesic_normalizer(geodesics).largest_distance, std::hypot(39, 2), 1);
    EXPECT_NEAR(geodesic_normalizer(geodesics, 10).largest_distance, std::hypot(39, 2), 1);
}

// Sweeps end where sources come again, and find what the fixed number of them would.
TEST(GeodesicNormalizer, IsTheLongWayThroughALongMesh) {
    const HeatGeodesics geodesics(shapes::cylinder(6, 2000, 1, 2000, true));
    EXPECT_NEAR(geodesic_normalizer(geodesics).largest_distance, 2000, 20);
}

TEST(NormalizedGeodesics, RowsAreTheDistancesDividedAndClamped) {
    TriangleMesh mesh = shapes::icosphere(2);
    mesh.vertices.push_back({7, 7, 7});
    const std::vector<double> distances = HeatGeodesics(mesh).distances(5);
    NormalizedGeodesics rows(HeatGeodesics(mesh), 2.0);
    const std::span<const double> row = rows.row(5);
    for (std::size_t i = 0; i + 1 < row.size(); ++i) {
        EXPECT_EQ(row[i], std::min(distances[i] / 2.0, 1.0));
    }
    EXPECT_EQ(row[mesh.vertices.size() - 1], 1) << "another component";
}

// Within a round nothing moves, whatever else is asked for and however small the limit.
TEST(NormalizedGeodesics, KeepEveryRowOfARoundWhereItIs) {
    for (const std::size_t limit : {NormalizedGeodesics::kCacheBytes, std::size_t{0}}) {
        NormalizedGeodesics rows(HeatGeodesics(shapes::icosphere(2)), 3.2, limit);
        EXPECT_EQ(rows.cached_rows(), 0);
        rows.prepare(std::vector<int>{9, 4, 9, 11});
        EXPECT_EQ(rows.cached_rows(), 3);
        const double* first = rows.row(4).data();
        for (int i = 20; i < 40; ++i) rows.row(i);
        EXPECT_EQ(rows.row(4).data(), first);
        EXPECT_EQ(rows.cached_rows(), 23);
    }
}

// Beyond the limit the rows of earlier rounds go, those used longest ago first.
TEST(NormalizedGeodesics, ForgetWhatWasUsedLongestAgo) {
    const TriangleMesh mesh = shapes::icosphere(2);
    const std::size_t row_bytes = mesh.vertices.size() * sizeof(double);
    NormalizedGeodesics rows(HeatGeodesics(mesh), 3.2, 3 * row_bytes);
    rows.prepare(std::vector<int>{1, 2, 3});
    rows.prepare(std::vector<int>{1});
    const std::vector<double> of_two(rows.row(2).begin(), rows.row(2).end());
    rows.prepare(std::vector<int>{5, 6});
    EXPECT_EQ(rows.cached_rows(), 3);
    EXPECT_EQ(rows.cached_bytes(), 3 * row_bytes);
    const double* of_five = rows.row(5).data();
    rows.prepare(std::vector<int>{7});
    EXPECT_EQ(rows.row(5).data(), of_five) << "2 was used before 5";
    EXPECT_EQ(rows.cached_bytes(), 3 * row_bytes);
    const auto again = rows.row(2);
    EXPECT_TRUE(std::equal(again.begin(), again.end(), of_two.begin(), of_two.end()))
        << "the same bits again";
}

TEST(NormalizedGeodesics, AreZeroWithinAComponentOfOnePlace) {
    TriangleMesh mesh = shapes::grid(2, 2);
    for (Point& p : mesh.vertices) p = {0, 0, 0};
    mesh.vertices.push_back({0, 0, 0});
    NormalizedGeodesics rows(HeatGeodesics(mesh), 0.0);
    const std::span<const double> row = rows.row(0);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(row[i], 0);
    EXPECT_EQ(row[4], 1);
}

TEST(NormalizedGeodesics, RefuseANormalizerThatIsNoDistance) {
    EXPECT_THROW(NormalizedGeodesics(HeatGeodesics(shapes::grid(2, 2)), -1.0), NumericalError);
    EXPECT_THROW(NormalizedGeodesics(HeatGeodesics(shapes::grid(2, 2)), std::nan("")),
                 NumericalError);
}

}  // namespace
}  // namespace mscomp

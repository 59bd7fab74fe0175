// SPDX-License-Identifier: MIT
#include "mscomp/convert/contents.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "base/thrown_message.h"
#include "convert_cases.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/index.h"
#include "mscomp/convert/authors_text.h"

namespace mscomp {
namespace {

using namespace cases;

// aligned = R input + t, with R a quarter turn about z and t = (0.1, -0.2, 7): the input of
// aligned (x, y, z) is (y + 0.2, -(x - 0.1), z - 7).
TEST(FeatureShapes, StandWhereTheInputStood) {
    const FeatureSet set = full_set();
    const FeatureShapes aligned(set, true), back(set, false);
    for (std::size_t i = 0; i < 4; ++i) {
        const Point there = aligned.shape(1)[i], here = back.shape(1)[i];
        EXPECT_EQ(there[0], static_cast<double>(set.vertices[12 + 3 * i]));
        EXPECT_NEAR(here[0], there[1] + 0.2, 1e-12);
        EXPECT_NEAR(here[1], 0.1 - there[0], 1e-12);
        EXPECT_NEAR(here[2], there[2] - 7, 1e-12);
        EXPECT_EQ(aligned.shape(0)[i], back.shape(0)[i]);
    }
    EXPECT_EQ(back.faces(), set.reference.faces);
    EXPECT_EQ(back.names(), set.names);
}

TEST(CompleteFeatures, LeavesAWholeSetAlone) {
    const Contents contents = complete_features(full_set(), 2, 4, "x", {});
    expect_same(*contents.features, full_set());
    EXPECT_TRUE(contents.notes.empty());
    EXPECT_FALSE(contents.took_reference);
}

// Vertices are made on the reference, which has to be a surface.
TEST(CompleteFeatures, NamesTheFileWhoseReferenceHasNoArea) {
    FeatureSet set = full_set();
    set.vertices.clear();
    for (Point& point : set.reference.vertices) point = {1, 2, 3};
    EXPECT_THAT(thrown_message<InputError>([&] { complete_features(set, 2, 4, "x.npz", {}); }),
                testing::StartsWith("x.npz: vertices cannot be made"));
}

// Sound features can describe a shape that float32 cannot hold.
TEST(CompleteFeatures, NamesTheShapeWhoseVerticesAreBeyondFloat32) {
    FeatureSet set = full_set();
    set.vertices.clear();
    std::fill(set.features.begin(), set.features.end(), 0.0F);
    for (int v = 0; v < 4; ++v) {
        for (const int k : {3, 6, 8}) set.features[at(36 + 9 * v + k)] = 3e38F;
    }
    for (Point& point : set.reference.vertices) {
        for (double& x : point) x *= 1e10;
    }
    EXPECT_THAT(thrown_message<InputError>([&] { complete_features(set, 2, 4, "x.npz", {}); }),
                testing::HasSubstr("x.npz: vertices cannot be made from the features: those of "
                                   "shape 1 are beyond float32"));
}

/// Largest distance along an axis once both stand on their centroids.
double largest_difference(const std::vector<Point>& a, const std::vector<Point>& b) {
    double largest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        double shift = 0;
        for (std::size_t i = 0; i < a.size(); ++i) shift += (a[i][k] - b[i][k]) / double(a.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            const double error = std::abs(a[i][k] - b[i][k] - shift);
            if (!(error <= largest)) largest = error;
        }
    }
    return largest;
}

// Their text has six digits; the bar is 2.2 long.
TEST(CompleteFeatures, TheAuthorsTextGivesTheirTwistedBar) {
    const std::string base = MSCOMP_SHARED_DIR "/reference/acap-bar/";
    if (!std::filesystem::exists(base)) GTEST_SKIP() << base << " is not there";
    Supplement supplement;
    supplement.reference = read_mesh(base + "1.obj");
    const AuthorsText r = parse_authors_text(read_file(base + "LOGRNEW_withopt_GT.txt"),
                                             AuthorsMatrix::log_rotation, "r");
    const AuthorsText s =
        parse_authors_text(read_file(base + "S_withopt_GT.txt"), AuthorsMatrix::stretch, "s");
    FeatureSet set;
    set.features = join_authors_text(r, s, "s");
    set.weights.clear();
    const Contents contents = complete_features(std::move(set), 3, 1154, "x", supplement);
    const FeatureShapes shapes(*contents.features, false);
    EXPECT_LE(largest_difference(shapes.shape(0), supplement.reference->vertices), 1e-6);
    EXPECT_LE(largest_difference(shapes.shape(1), read_mesh(base + "2.obj").vertices), 5e-6);
}

}  // namespace
}  // namespace mscomp

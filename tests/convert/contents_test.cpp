// SPDX-License-Identifier: MIT
#include "mscomp/convert/contents.h"

#include <gtest/gtest.h>

#include "convert_cases.h"

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

}  // namespace
}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "cli/shape_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using testing::ElementsAre;

TEST(ShapeRange, IsHalfOpenAndEitherEndMayBeLeftOut) {
    EXPECT_EQ(parse_shape_range("2:5", 10).begin, 2);
    EXPECT_EQ(parse_shape_range("2:5", 10).end, 5);
    EXPECT_EQ(parse_shape_range(":", 10).size(), 10);
    EXPECT_EQ(parse_shape_range("7:", 10).size(), 3);
    EXPECT_EQ(parse_shape_range(":7", 10).size(), 7);
}

TEST(ShapeRange, RefusesWhatIsNoRangeOfThese) {
    for (const char* text : {"", "3", "5:2", "3:3", "0:11", "-1:3", "a:3", "1:2:3", "1.5:3"}) {
        EXPECT_THROW(parse_shape_range(text, 10), UsageError) << text;
    }
}

TEST(ShapeFileNames, PlainUniqueNamesStay) {
    EXPECT_THAT(shape_file_names({"frame_2", "frame 10"}), ElementsAre("frame_2", "frame_10"));
}

TEST(ShapeFileNames, NeverCollideAndNeverLeaveTheFolder) {
    const std::vector<std::string> names = shape_file_names(
        {"a/b", "a_b", "", "..", "../../etc/passwd", ".hidden", "x", "x", "0007_x"});
    EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
    for (const std::string& name : names) {
        EXPECT_EQ(name.find('/'), std::string::npos) << name;
        EXPECT_FALSE(name.empty() || name[0] == '.') << name;
    }
}

}  // namespace
}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/acap/mesh/natural_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "mscomp/acap/mesh/mesh_sequence.h"

namespace mscomp {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Names = std::vector<std::string>;

/// In their order, whatever order they come in; the doubt there is about it.
Names sorted(Names names, std::string* doubt = nullptr) {
    Names first;
    for (int turn = 0; turn < 3; ++turn) {
        const NaturalOrder order(names);
        order.sort(names);
        if (turn == 0) first = names;
        EXPECT_EQ(names, first);
        for (std::size_t i = 1; i < names.size(); ++i) {
            EXPECT_TRUE(order.less(names[i - 1], names[i])) << names[i - 1] << " " << names[i];
            EXPECT_FALSE(order.less(names[i], names[i - 1])) << names[i - 1] << " " << names[i];
        }
        if (doubt != nullptr) *doubt = order.doubt();
        std::reverse(names.begin(), names.end());
        if (turn == 1) std::rotate(names.begin(), names.begin() + names.size() / 2, names.end());
    }
    return first;
}

void expect_order(const Names& wanted) {
    std::string doubt;
    Names shuffled = wanted;
    std::reverse(shuffled.begin(), shuffled.end());
    EXPECT_EQ(sorted(shuffled, &doubt), wanted);
    EXPECT_THAT(doubt, IsEmpty());
}

TEST(NaturalOrderOfASet, TakesFractionsWhereTheSetShowsThem) {
    expect_order({"f.1.obj", "f.1.25.obj", "f.1.5.obj", "f.2.obj", "f.10.obj"});
    expect_order({"0.obj", "0.05.obj", "0.25.obj", "0.5.obj", "1.obj", "1.125.obj"});
    expect_order({"f0.0.ply", "f0.25.ply", "f0.5.ply", "f0.75.ply", "f1.0.ply", "f10.0.ply"});
    expect_order({"t_0.125_x.obj", "t_0.25_x.obj", "t_0.5_x.obj"});
}

TEST(NaturalOrderOfASet, TakesCountersWhereTheSetShowsThem) {
    expect_order({"v1.2.9.obj", "v1.2.10.obj", "v1.10.1.obj"});
    expect_order({"v1.8.obj", "v1.9.obj", "v1.10.obj", "v1.11.obj"});
    expect_order({"2024.01.05.obj", "2024.1.6.obj", "2024.10.01.obj"});
    expect_order({"s1.25.obj", "s1.50.obj", "s1.75.obj", "s2.00.obj"});  // both readings agree
}

// Two of one person, three of another: nothing tells.
TEST(NaturalOrderOfASet, SaysWhatItDoesWhereNothingTells) {
    std::string doubt;
    EXPECT_EQ(sorted({"p3.12.obj", "p3.7.obj", "p4.9.obj"}, &doubt),
              Names({"p3.7.obj", "p3.12.obj", "p4.9.obj"}));
    EXPECT_THAT(doubt, HasSubstr("p3.7.obj comes before p3.12.obj"));
}

TEST(NaturalOrderOfASet, TakesSignsWhereTheSetShowsThem) {
    expect_order({"-2.obj", "-1.obj", "0.obj", "1.obj", "2.obj"});
    expect_order({"-10.obj", "-9.obj", "-1.obj"});
    expect_order({"f-2.obj", "f-1.obj", "f0.obj", "f1.obj", "f10.obj"});
    expect_order({"f_-2.obj", "f_-1.obj", "f_0.obj", "f_+1.obj"});
    expect_order({"f--2.obj", "f--1.obj", "f-0.obj", "f-1.obj"});
    expect_order({"t=-1.5.obj", "t=-1.25.obj", "t=-1.obj", "t=0.obj", "t=0.5.obj"});
    expect_order({"a1-2.obj", "a1-10.obj", "a2-1.obj"});
}

TEST(NaturalOrderOfASet, TakesAHyphenForASeparatorOtherwise) {
    expect_order({"a-1.obj", "a-2.obj", "a-10.obj"});
    expect_order({"2024-01-02.obj", "2024-01-10.obj", "2024-02-01.obj"});
    expect_order({"1.obj", "1-2.obj", "1-3.obj"});
    expect_order({"take-1_f-9.obj", "take-1_f-10.obj", "take-2_f-1.obj"});
}

TEST(NaturalOrderOfASet, ReadsExponentsAlongWithFractions) {
    expect_order({"d1e-05.obj", "d0.0001.obj", "d0.001.obj", "d1.obj", "d2e3.obj"});
    std::string doubt;
    sorted({"d1e3.obj", "d2e2.obj"}, &doubt);
    EXPECT_THAT(doubt, HasSubstr("in doubt"));
}

TEST(NaturalOrderOfASet, GoesFolderByFolder) {
    expect_order({"take2/9.obj", "take2/10.obj", "take10/1.obj"});
    expect_order({"a/b/2.obj", "a/b/10.obj", "a/b2/1.obj", "a-1/b/1.obj"});
    expect_order({"x/1.obj", "x/1.off", "x/1.ply"});
}

TEST(NaturalOrderOfASet, BreaksTiesByteByByte) {
    expect_order({"f007.obj", "f07.obj", "f7.obj"});
    expect_order({"f0.5.obj", "f0.50.obj", "f1.0.obj"});
    expect_order({"F1.obj", "f1.obj", "\xc3\xa9.obj", "\xe4\xb8\xad.obj"});
}

TEST(ShapeNames, KeepTheFoldersThatTellThemApart) {
    EXPECT_EQ(shape_names({"in/take1/frame.obj", "in/take2/frame.obj"}),
              Names({"take1_frame", "take2_frame"}));
    EXPECT_EQ(shape_names({"in/take1/mesh/1.obj", "in/take1/mesh/2.obj", "in/take2/mesh/1.obj"}),
              Names({"take1_1", "take1_2", "take2_1"}));
    EXPECT_EQ(shape_names({"./a/1.obj", "b/../c/1.obj"}), Names({"a_1", "c_1"}));
    EXPECT_EQ(shape_names({"a/1.obj", "1.obj"}), Names({"a_1", "1"}));
    EXPECT_EQ(shape_names({"a/1.obj", "b/2.obj"}), Names({"1", "2"}));  // clear without
    EXPECT_EQ(shape_names({"1.obj", "1.off", "1.ply"}), Names({"1", "1-2", "1-3"}));
    EXPECT_EQ(shape_names({"a_b/c.obj", "a/b_c.obj", "x/c.obj"}),
              Names({"a_b_c", "a_b_c-2", "x_c"}));
}

}  // namespace
}  // namespace mscomp

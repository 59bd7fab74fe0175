// SPDX-License-Identifier: MIT
#include "mscomp/render/family_layout.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

// 0 alone; 1 with 3, 4, 5, of which 4 has 6, 7; 2 with 8.
const std::vector<int> kParents{-1, -1, -1, 1, 1, 1, 4, 4, 2};

TEST(FamilyLayout, PutsChildrenToTheRightOfTheirParent) {
    const FamilyLayout layout = family_layout(kParents, 4);
    const std::vector<GridPlace> wanted{{0, 0}, {1, 0}, {3, 0}, {2, 1}, {1, 1},
                                        {2, 2}, {1, 2}, {1, 3}, {3, 1}};
    EXPECT_EQ(layout.places, wanted);
    EXPECT_EQ(layout.rows, 4);
    EXPECT_EQ(layout.columns, 4);
    ASSERT_EQ(layout.families.size(), 3u);
    EXPECT_EQ(layout.families[0].root, -1);
    EXPECT_EQ(layout.families[1].root, 1);
    EXPECT_EQ(layout.families[1].members, 6);
    EXPECT_EQ(layout.families[1].rows, 2);
    EXPECT_EQ(layout.families[2].first_row, 3);
}

TEST(FamilyLayout, PutsFamiliesBesideEachOtherWhereThereIsRoom) {
    const FamilyLayout layout = family_layout(kParents, 6);
    EXPECT_EQ(layout.places[2], (GridPlace{1, 4}));
    EXPECT_EQ(layout.places[8], (GridPlace{1, 5}));
    EXPECT_EQ(layout.families[2].column, 4);
    EXPECT_EQ(layout.rows, 3);
}

// Whatever the width: no place twice, each child right of its parent or, at the edge, below it, and
// within the rows of its family and of the branch that leads to it.
TEST(FamilyLayout, KeepsFamiliesTogetherAtAnyWidth) {
    std::vector<int> parents{-1, -1, -1};
    for (int i = 0; i < 60; ++i) parents.push_back(i % 7 == 0 ? i % 3 : (i * i + 1) % (i + 3));
    for (int columns = 1; columns <= 12; ++columns) {
        const FamilyLayout layout = family_layout(parents, columns);
        std::set<std::pair<int, int>> taken;
        for (std::size_t i = 0; i < parents.size(); ++i) {
            const GridPlace& place = layout.places[i];
            EXPECT_TRUE(taken.insert({place.row, place.column}).second);
            EXPECT_LT(place.column, columns);
            EXPECT_LT(place.row, layout.rows);
            if (parents[i] < 0) continue;
            const GridPlace& parent = layout.places[at(parents[i])];
            EXPECT_TRUE(place.column > parent.column || place.row > parent.row);
            EXPECT_GE(place.row, parent.row);
            for (const Branch& branch : layout.branches) {
                if (branch.parent != parents[i]) continue;
                EXPECT_GE(place.row, branch.first_row);
                EXPECT_LE(place.row, branch.last_row);
                EXPECT_GE(place.column, branch.column);
            }
        }
        int members = 0;
        for (const Family& family : layout.families) members += family.members;
        EXPECT_EQ(members, static_cast<int>(parents.size()));
    }
}

TEST(FamilyLayout, RefusesParentsThatComeLater) {
    EXPECT_THROW(family_layout(std::vector<int>{1, -1}, 4), UsageError);
    EXPECT_THROW(family_layout(std::vector<int>{0}, 4), UsageError);
    EXPECT_THROW(family_layout(std::vector<int>{-2}, 4), UsageError);
    EXPECT_THROW(family_layout(kParents, 0), UsageError);
    EXPECT_EQ(family_layout(std::vector<int>{}, 4).rows, 0);
}

}  // namespace
}  // namespace mscomp

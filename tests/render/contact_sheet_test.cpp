// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "mscomp/base/error.h"
#include "mscomp/render/render.h"

namespace mscomp {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

Image plain(int width, int height, const Rgb& color) {
    Image image{width, height, {}};
    for (int i = 0; i < width * height; ++i) {
        image.rgb.insert(image.rgb.end(), color.begin(), color.end());
    }
    return image;
}

/// Where a colour occurs: its bounding box and the number of its pixels.
struct Place {
    int left = 1 << 30, right = -1, top = 1 << 30, bottom = -1, count = 0;
};

Place find(const Image& image, const Rgb& color) {
    Place place;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const auto at = static_cast<std::size_t>(y * image.width + x) * 3;
            if (!std::equal(color.begin(), color.end(),
                            image.rgb.begin() + static_cast<long>(at))) {
                continue;
            }
            place.left = std::min(place.left, x);
            place.right = std::max(place.right, x);
            place.top = std::min(place.top, y);
            place.bottom = std::max(place.bottom, y);
            ++place.count;
        }
    }
    return place;
}

int dark_pixels(const Image& image, int top, int bottom) {
    int count = 0;
    for (int y = top; y < bottom; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const auto at = static_cast<std::size_t>(y * image.width + x) * 3;
            const int high = std::max({image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]});
            const int low = std::min({image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]});
            count += high < 150 && high == low;
        }
    }
    return count;
}

const Rgb kRed{255, 0, 0}, kGreen{0, 255, 0}, kBlue{0, 0, 255};

std::vector<SheetTile> tiles() {
    return {{plain(80, 60, kGreen), "second group", 1},
            {plain(80, 60, kRed), "first", 0},
            {plain(80, 60, kBlue), "next", 0}};
}

// Every picture is there whole and once.
TEST(ContactSheet, HoldsEveryPicture) {
    const Image sheet = contact_sheet(tiles(), {"Coarse", "Fine"}, "Title", 4);
    for (const Rgb& color : {kRed, kGreen, kBlue}) {
        const Place place = find(sheet, color);
        EXPECT_EQ(place.count, 80 * 60);
        EXPECT_EQ(place.right - place.left, 79);
        EXPECT_EQ(place.bottom - place.top, 59);
    }
}

// Groups stand in ascending order, tiles of one group in theirs, side by side.
TEST(ContactSheet, KeepsTheOrderOfGroupsAndTiles) {
    const Image sheet = contact_sheet(tiles(), {"Coarse", "Fine"}, "Title", 4);
    const Place red = find(sheet, kRed), blue = find(sheet, kBlue), green = find(sheet, kGreen);
    EXPECT_EQ(red.top, blue.top);
    EXPECT_LT(red.right, blue.left);
    EXPECT_GT(green.top, red.bottom);
    EXPECT_EQ(green.left, red.left);
}

TEST(ContactSheet, BreaksRows) {
    const Image sheet = contact_sheet(tiles(), {"Coarse", "Fine"}, "", 1);
    EXPECT_GT(find(sheet, kBlue).top, find(sheet, kRed).bottom);
    EXPECT_EQ(find(sheet, kBlue).left, find(sheet, kRed).left);
}

// Text is there: below each picture, above each group, at the top; and only where it was asked for.
TEST(ContactSheet, WritesTitleHeadingsAndLabels) {
    const Image sheet = contact_sheet(tiles(), {"Coarse", "Fine"}, "Title", 4);
    const Place red = find(sheet, kRed), green = find(sheet, kGreen);
    EXPECT_GT(dark_pixels(sheet, 0, red.top - 40), 20) << "title";
    EXPECT_GT(dark_pixels(sheet, red.top - 40, red.top), 20) << "heading";
    EXPECT_GT(dark_pixels(sheet, red.bottom + 1, red.bottom + 25), 20) << "labels";
    EXPECT_GT(dark_pixels(sheet, green.bottom + 1, sheet.height), 20) << "label of the last row";

    const Image silent = contact_sheet({{plain(80, 60, kRed), "", 0}}, {""}, "", 4);
    EXPECT_EQ(dark_pixels(silent, 0, silent.height), 0);
}

// A label stays within its picture's width, however long.
TEST(ContactSheet, CutsLongLabels) {
    const std::string endless(200, 'm');
    const Image sheet = contact_sheet({{plain(80, 60, kRed), endless, 0}}, {""}, "", 4);
    const Place red = find(sheet, kRed);
    for (int y = red.bottom + 1; y < sheet.height; ++y) {
        for (int x = 0; x < sheet.width; ++x) {
            if (x >= red.left - 1 && x <= red.right + 1) continue;
            EXPECT_EQ(sheet.rgb[static_cast<std::size_t>(y * sheet.width + x) * 3], 255);
        }
    }
    EXPECT_GT(dark_pixels(sheet, red.bottom + 1, sheet.height), 50);
}

// Every letter looks different from every other.
TEST(ContactSheet, KnowsItsLetters) {
    std::set<std::vector<std::uint8_t>> pictures;
    int letters = 0;
    for (char letter = '!'; letter <= '~'; ++letter) {
        if (std::string("$@\\^`{}").find(letter) != std::string::npos) continue;
        const Image sheet =
            contact_sheet({{plain(80, 60, kRed), "", 0}}, {""}, std::string(1, letter), 1);
        pictures.insert(sheet.rgb);
        ++letters;
    }
    EXPECT_EQ(static_cast<int>(pictures.size()), letters);
}

TEST(ContactSheet, RefusesWhatDoesNotFit) {
    EXPECT_THROW(contact_sheet({}, {"Coarse"}, "Title", 4), UsageError);
    EXPECT_THROW(contact_sheet(tiles(), {"Coarse"}, "Title", 4), UsageError);
    EXPECT_THROW(contact_sheet(tiles(), {"Coarse", "Fine"}, "Title", 0), UsageError);
    std::vector<SheetTile> uneven = tiles();
    uneven[2].image = plain(81, 60, kBlue);
    EXPECT_THROW(contact_sheet(uneven, {"Coarse", "Fine"}, "Title", 4), UsageError);
}

}  // namespace
}  // namespace mscomp

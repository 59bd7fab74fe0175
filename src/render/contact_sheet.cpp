// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>

#include "canvas.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/render/render.h"
#include "stroke_font.h"

namespace mscomp {
namespace {

// Pixels.
constexpr int kSheetMargin = 28;
constexpr int kSheetGap = 14;
constexpr int kTitleHeight = 44;
constexpr int kHeadingHeight = 44;
constexpr int kLabelHeight = 30;
constexpr double kTitleCaps = 17, kHeadingCaps = 12, kLabelCaps = 9.5;
constexpr double kBlack = 0.12, kGray = 0.35, kRule = 0.82;

void check(const std::vector<SheetTile>& tiles, const std::vector<std::string>& headings,
           int columns) {
    if (tiles.empty()) throw UsageError("contact sheet: there are no pictures to put on it");
    if (columns < 1) throw UsageError(fmt::format("contact sheet: {} columns", columns));
    const Image& first = tiles.front().image;
    for (const SheetTile& tile : tiles) {
        const Image& image = tile.image;
        const auto size = at(image.width) * at(image.height) * 3;
        if (image.width != first.width || image.height != first.height ||
            image.rgb.size() != size || size == 0) {
            throw UsageError(
                fmt::format("contact sheet: picture '{}' is {} x {}, wanted {} x {} as the first",
                            tile.label, image.width, image.height, first.width, first.height));
        }
        if (tile.group < 0 || tile.group >= static_cast<int>(headings.size())) {
            throw UsageError(
                fmt::format("contact sheet: picture '{}' is in group {}, there are {} headings",
                            tile.label, tile.group, headings.size()));
        }
    }
}

/// The tiles of each group in the order given.
std::vector<std::vector<const SheetTile*>> grouped(const std::vector<SheetTile>& tiles,
                                                   std::size_t groups) {
    std::vector<std::vector<const SheetTile*>> result(groups);
    for (const SheetTile& tile : tiles) {
        result[at(tile.group)].push_back(&tile);
    }
    return result;
}

int rows_for(std::size_t tiles, int columns) {
    return (static_cast<int>(tiles) + columns - 1) / columns;
}

void draw_rule(Image& sheet, int row) {
    constexpr auto kInk = static_cast<std::uint8_t>(255 * kRule);
    fill(sheet, {kSheetMargin, row, sheet.width - 2 * kSheetMargin, 1}, {kInk, kInk, kInk});
}

void draw_label(Image& sheet, const SheetTile& tile, int left, int top) {
    const double width = tile.image.width;
    const std::string label = text_cut_to(tile.label, kLabelCaps, width);
    const double x = left + 0.5 * (width - text_width(label, kLabelCaps));
    draw_text(sheet, x, top + tile.image.height + 16, label, kLabelCaps, kGray);
}

}  // namespace

Image contact_sheet(const std::vector<SheetTile>& tiles, const std::vector<std::string>& headings,
                    const std::string& title, int columns) {
    check(tiles, headings, columns);
    const auto groups = grouped(tiles, headings.size());
    std::size_t widest = 0;
    for (const auto& group : groups) widest = std::max(widest, group.size());
    columns = std::min(columns, static_cast<int>(widest));

    const Image& first = tiles.front().image;
    const int column_width = first.width + kSheetGap;
    const int row_height = first.height + kLabelHeight;
    int height = 2 * kSheetMargin + (title.empty() ? 0 : kTitleHeight);
    for (const auto& group : groups) {
        if (group.empty()) continue;
        height += kHeadingHeight + rows_for(group.size(), columns) * row_height;
    }
    Image sheet = blank_picture(2 * kSheetMargin + columns * column_width - kSheetGap, height);

    const double text_space = sheet.width - 2 * kSheetMargin;
    int top = kSheetMargin;
    if (!title.empty()) {
        draw_text(sheet, kSheetMargin, top + kTitleCaps, text_cut_to(title, kTitleCaps, text_space),
                  kTitleCaps, kBlack);
        top += kTitleHeight;
    }
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (groups[g].empty()) continue;
        draw_text(sheet, kSheetMargin, top + 16, text_cut_to(headings[g], kHeadingCaps, text_space),
                  kHeadingCaps, kBlack);
        draw_rule(sheet, top + 26);
        top += kHeadingHeight;
        for (std::size_t k = 0; k < groups[g].size(); ++k) {
            const int row = static_cast<int>(k) / columns, column = static_cast<int>(k) % columns;
            const int x = kSheetMargin + column * column_width, y = top + row * row_height;
            paste(sheet, groups[g][k]->image, x, y);
            draw_label(sheet, *groups[g][k], x, y);
        }
        top += rows_for(groups[g].size(), columns) * row_height;
    }
    return sheet;
}

}  // namespace mscomp

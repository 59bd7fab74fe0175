// SPDX-License-Identifier: MIT
#include "mscomp/render/overview.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "canvas.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/points.h"
#include "stroke_font.h"

namespace mscomp {
namespace {

// Pixels.
constexpr int kEdge = 28, kTileGap = 26, kCaptionHeight = 30, kTopHeight = 44, kFamilyHeading = 46;
constexpr int kInsetGap = 5, kHeaderHeight = 250, kHeaderPicture = 210, kLeastWidth = 1000;
constexpr int kBarWidth = 400, kBarHeight = 16;
constexpr double kTopCaps = 17, kFamilyCaps = 12, kCaptionCaps = 10.5, kNoteCaps = 10.5;
constexpr double kDark = 0.12, kPale = 0.38;
constexpr Ink kFrameInk{214, 214, 214}, kRuleInk{209, 209, 209}, kBranchInk{150, 150, 150},
    kMarkInk{214, 92, 0};

/// Sizes that follow from that of one picture.
struct TileSize {
    int side = 0, inset_width = 0, inset_height = 0;

    explicit TileSize(int tile)
        : side(tile), inset_width(std::max(1, tile * 36 / 100)), inset_height(tile * 62 / 100) {}
    int width() const { return side + kInsetGap + inset_width; }
    int height() const { return side + kCaptionHeight; }
};

std::vector<std::array<float, 3>> colors_of_motion(const Motion& motion, const OverviewPlan& plan) {
    std::vector<std::array<float, 3>> colors;
    for (const double amount : motion.amount) {
        const double percent = 100 * amount / plan.diagonal;
        colors.push_back(white_to_blue(static_cast<float>(place_on_scale(percent, plan.largest))));
    }
    return colors;
}

/// Where what `zoom` shows lies in a picture of `whole`, both of the same direction, as far as it
/// is in the picture.
Box seen_box(const View& zoom, const View& whole, int width, int height) {
    const double scale = 0.5 * std::min(width, height) / whole.half_extent;
    const Point offset = minus(zoom.center, whole.center);
    const double x = 0.5 * width + scale * dot(offset, whole.axes[0]);
    const double y = 0.5 * height - scale * dot(offset, whole.axes[1]);
    const double half = scale * zoom.half_extent;
    const auto pixel = [](double place, int size) {
        return static_cast<int>(std::lround(std::clamp(place, 0.0, static_cast<double>(size))));
    };
    const int left = pixel(x - half, width), top = pixel(y - half, height);
    return {left, top, pixel(x + half, width) - left, pixel(y + half, height) - top};
}

Image tile_picture(const TriangleMesh& reference, const std::vector<Point>& moved,
                   const OverviewTile& tile, const OverviewPlan& plan, const TileSize& size) {
    Image picture = blank_picture(size.width(), size.side);
    const Box frame{0, 0, size.side, size.side};
    if (!moved.empty()) {
        const TriangleMesh mesh{moved, reference.faces};
        const auto colors = colors_of_motion(tile.motion, plan);
        paste(picture, render_mesh(mesh, colors, tile.zoom, size.side, size.side), 0, 0);
        if (tile.is_zoomed) {
            const double aspect = static_cast<double>(size.inset_width) / size.inset_height;
            const View whole = framed(tile.whole, moved, aspect);
            Image inset = render_mesh(mesh, colors, whole, size.inset_width, size.inset_height);
            outline(inset, seen_box(tile.zoom, whole, inset.width, inset.height), kMarkInk);
            paste(picture, inset, size.side + kInsetGap, 0);
        }
        if (tile.near_empty) wash_out(picture);
    }
    outline(picture, frame, tile.is_zoomed && !tile.near_empty ? kMarkInk : kFrameInk);
    return picture;
}

std::string caption_of(const ShownMotion& motion, const OverviewTile& tile,
                       const OverviewPlan& plan) {
    if (motion.moved.empty()) return "not kept";
    const double percent = plan.diagonal > 0 ? 100 * tile.motion.largest / plan.diagonal : 0;
    if (tile.near_empty) return fmt::format("hardly moves ({:.2g} %)", percent);
    return fmt::format("{:.2g} %, {}", percent, name_of(tile.viewpoint));
}

/// Name in black and caption in grey, within `width`.
void draw_caption(Image& sheet, int left, int baseline, const std::string& name,
                  const std::string& caption, int width) {
    const std::string shown = text_cut_to(name, kCaptionCaps, width);
    draw_text(sheet, left, baseline, shown, kCaptionCaps, kDark);
    const double used = text_width(shown, kCaptionCaps) + 12;
    draw_text(sheet, left + used, baseline, text_cut_to(caption, kCaptionCaps - 1, width - used),
              kCaptionCaps - 1, kPale);
}

void draw_scale(Image& sheet, const OverviewPlan& plan, int left, int top) {
    for (int x = 0; x < kBarWidth; ++x) {
        const auto color = white_to_blue((static_cast<float>(x) + 0.5F) / kBarWidth);
        Ink ink{};
        for (std::size_t c = 0; c < 3; ++c) {
            ink[c] = static_cast<std::uint8_t>(std::lround(255 * color[c]));
        }
        fill(sheet, {left + x, top, 1, kBarHeight}, ink);
    }
    outline(sheet, {left, top, kBarWidth, kBarHeight}, kBranchInk);
    for (const double tick : scale_ticks(plan.largest)) {
        const int x = left + static_cast<int>(
                                 std::lround((kBarWidth - 1) * place_on_scale(tick, plan.largest)));
        fill(sheet, {x, top + kBarHeight, 1, 5}, kBranchInk);
        const std::string number = fmt::format("{:.3g} %", tick);
        const double back = 0.5 * text_width(number, kNoteCaps - 1);
        draw_text(sheet, x - (tick > 0 ? back : 0), top + kBarHeight + 21, number, kNoteCaps - 1,
                  kDark);
    }
}

/// The reference, the colour bar and how to read the sheet.
void draw_header(Image& sheet, const TriangleMesh& reference, const OverviewPlan& plan, int top) {
    View view;
    view.axes = axes_from(plan.stance, tried_viewpoints().front());
    const Image picture = render_mesh(reference, {}, framed(view, reference.vertices),
                                      kHeaderPicture, kHeaderPicture);
    paste(sheet, picture, kEdge, top);
    outline(sheet, {kEdge, top, kHeaderPicture, kHeaderPicture}, kFrameInk);
    draw_text(sheet, kEdge, top + kHeaderPicture + 18, "reference, front", kCaptionCaps, kPale);

    const int left = kEdge + kHeaderPicture + kTileGap;
    const double space = sheet.width - kEdge - left;
    const auto line = [&](int baseline, const std::string& text) {
        draw_text(sheet, left, top + baseline, text_cut_to(text, kNoteCaps, space), kNoteCaps,
                  kDark);
    };
    line(14, "Displacement of each vertex, in % of the diagonal of the bounding box");
    draw_scale(sheet, plan, left, top + 26);
    line(94, "One component each, alone, at the end that moves the shape more.");
    line(118, "Zoomed to what moves; beside it the whole, with that place marked.");
    line(142, "Below: the largest displacement, and the side it is seen from (the viewer's).");
    line(166, "Lines lead from a component to those that refine it.");
    line(190, fmt::format("Greyed: moves less than {:g} % of the one that moves most.",
                          100 * kNearEmptyShare));
    line(214, fmt::format("Up is {}{}, the front, where the reference is seen from, {}.",
                          axis_name(plan.stance.up), plan.is_up_guessed ? " (a guess)" : "",
                          axis_name(plan.stance.front)));
}

/// Pixels of grid places, below the header.
struct SheetGrid {
    TileSize size;
    std::vector<int> row_tops;

    int left(int column) const { return kEdge + column * (size.width() + kTileGap); }
    int top(int row) const { return row_tops[at(row)]; }
};

/// From the right of a parent to its children, and along their rows.
void draw_branch(Image& sheet, const Branch& branch, const GridPlace& parent,
                 const SheetGrid& grid) {
    const int x = grid.left(branch.column) - kTileGap / 2;
    const int middle = grid.size.side / 2;
    if (branch.column > parent.column) {
        const int from = grid.left(parent.column) + grid.size.side + 1;
        const int y = grid.top(parent.row) + grid.size.inset_height +
                      (grid.size.side - grid.size.inset_height) / 2;
        fill(sheet, {from, y, x - from, 2}, kBranchInk);
    }
    const int top = grid.top(branch.first_row);
    const int bottom = grid.top(branch.last_row) + grid.size.side;
    fill(sheet, {x, top, 2, bottom - top}, kBranchInk);
    for (int row = branch.first_row; row <= branch.last_row; ++row) {
        fill(sheet, {x, grid.top(row) + middle, kTileGap / 2, 2}, kBranchInk);
    }
}

std::string family_heading(const Family& family, std::span<const ShownMotion> motions) {
    if (family.root < 0) {
        return fmt::format("{} without finer ones", family.members);
    }
    return fmt::format("{} and what refines it: {} in all", motions[at(family.root)].name,
                       family.members);
}

}  // namespace

Image draw_overview(const TriangleMesh& reference, std::span<const ShownMotion> motions,
                    const OverviewPlan& plan, const OverviewOptions& options) {
    const TileSize size(options.tile);
    std::vector<Image> pictures(motions.size());
    parallel_for(static_cast<std::int64_t>(motions.size()), [&](std::int64_t i) {
        pictures[at(i)] =
            tile_picture(reference, motions[at(i)].moved, plan.tiles[at(i)], plan, size);
    });

    SheetGrid grid{size, std::vector<int>(at(plan.layout.rows), 0)};
    int height = kEdge + kTopHeight + kHeaderHeight;
    for (int row = 0; row < plan.layout.rows; ++row) {
        if (std::ranges::any_of(plan.layout.families,
                                [row](const Family& f) { return f.first_row == row; })) {
            height += kFamilyHeading;
        }
        grid.row_tops[at(row)] = height;
        height += size.height();
    }
    const int width = grid.left(plan.layout.columns) - kTileGap + kEdge;
    Image sheet = blank_picture(std::max(kLeastWidth, width), height + kEdge);

    const double space = sheet.width - 2 * kEdge;
    draw_text(sheet, kEdge, kEdge + kTopCaps, text_cut_to(options.title, kTopCaps, space), kTopCaps,
              kDark);
    draw_header(sheet, reference, plan, kEdge + kTopHeight);
    for (const Family& family : plan.layout.families) {
        const int left = grid.left(family.column), top = grid.top(family.first_row);
        const int wide = family.columns * (size.width() + kTileGap) - kTileGap;
        draw_text(sheet, left, top - kFamilyHeading + 20,
                  text_cut_to(family_heading(family, motions), kFamilyCaps, wide), kFamilyCaps,
                  kDark);
        fill(sheet, {left, top - kFamilyHeading + 30, wide, 1}, kRuleInk);
    }
    for (std::size_t i = 0; i < motions.size(); ++i) {
        const GridPlace& place = plan.layout.places[i];
        const int left = grid.left(place.column), top = grid.top(place.row);
        paste(sheet, pictures[i], left, top);
        draw_caption(sheet, left, top + size.side + 17, motions[i].name,
                     caption_of(motions[i], plan.tiles[i], plan), size.width());
    }
    for (const Branch& branch : plan.layout.branches) {
        draw_branch(sheet, branch, plan.layout.places[at(branch.parent)], grid);
    }
    return sheet;
}

}  // namespace mscomp

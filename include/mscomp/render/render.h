// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// 8-bit RGB picture, rows from the top.
struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;  // (height, width, 3)
};

/// Orthographic view: right, up and towards-the-viewer axes (rows, orthonormal) and what fills the
/// picture.
struct View {
    std::array<Point, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    Point center{0, 0, 0};
    double half_extent = 1;  // distance from the centre to the nearer picture edge, in mesh units
};

/// A view that shows `vertices` well: the up axis is the coordinate axis of ... (documented in the
/// .cpp), framed so that all of `vertices` fit with a margin.
View fit_view(std::span<const Point> vertices);

/// Draws a mesh with smooth two-sided shading, depth and 3x3 supersampling; `colors` (V,3) in
/// [0,1].
Image render_mesh(const TriangleMesh& mesh, std::span<const std::array<float, 3>> colors,
                  const View& view, int width, int height);

/// One labelled picture of a contact sheet.
struct SheetTile {
    Image image;
    std::string label;
    int group =
        0;  // tiles of one group stand together under one heading, groups in ascending order
};

/// Puts tiles of equal size in rows of `columns`, grouped with a heading each (`headings[group]`),
/// labels below each tile.
Image contact_sheet(const std::vector<SheetTile>& tiles, const std::vector<std::string>& headings,
                    const std::string& title, int columns);

/// Writes a PNG as one atomic step. Throws IoError.
void write_png(const std::string& path, const Image& image);

/// The papers' colouring: white where amount = 0, blue where amount = 1.
std::array<float, 3> white_to_blue(float amount);

}  // namespace mscomp

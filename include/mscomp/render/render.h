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
    double aspect = 1;       // width / height of what is seen: a hint for the size of the picture
};

/// A view that shows `vertices` well, without being told what they are:
/// * up and front are guessed (stance_of);
/// * the viewer is in front (so that the longer extent is spread out), turned by 30 degrees about
///   the up axis and 12 degrees from above;
/// * framed so that all vertices fit into a picture of `picture_aspect` = width / height with a
///   margin of 4 %.
/// Throws MeshError if there are no vertices or one is not finite.
View fit_view(std::span<const Point> vertices, double picture_aspect = 1.0);

/// The same direction of view, framed anew so that all of `vertices` fit: several shapes seen
/// alike.
View framed(View view, std::span<const Point> vertices, double picture_aspect = 1.0);

/// Width and height in pixels that suit what is seen, the longer one as given. With it:
///   View view = fit_view(points);
///   const auto [width, height] = picture_size(view, 340);
///   view = fit_view(points, static_cast<double>(width) / height);
std::array<int, 2> picture_size(const View& view, int longer_side);

/// Draws a mesh with smooth two-sided shading, depth and 3x3 supersampling on white; `colors` (V,3)
/// in [0,1], or empty for white. The same bytes for any number of threads. Throws MeshError (empty
/// mesh, wrong number of colours, coordinates not finite, face index out of range) or UsageError
/// (picture without pixels).
Image render_mesh(const TriangleMesh& mesh, std::span<const std::array<float, 3>> colors,
                  const View& view, int width, int height);

/// One labelled picture of a contact sheet.
struct SheetTile {
    Image image;
    std::string label;  // ASCII; cut off with dots where it is wider than the picture
    int group =
        0;  // tiles of one group stand together under one heading, groups in ascending order
};

/// Puts tiles of equal size in rows of `columns`, grouped with a heading each (`headings[group]`),
/// labels below each tile. Throws UsageError (no tiles, sizes differ, a group without heading).
Image contact_sheet(const std::vector<SheetTile>& tiles, const std::vector<std::string>& headings,
                    const std::string& title, int columns);

/// Writes a PNG as one atomic step. Throws IoError, or UsageError for a picture without pixels.
void write_png(const std::string& path, const Image& image);

/// The papers' colouring: white where amount = 0, blue where amount = 1; amounts outside [0, 1]
/// count as the nearer end, NaN as 0.
std::array<float, 3> white_to_blue(float amount);

}  // namespace mscomp

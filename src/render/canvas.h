// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "mscomp/render/render.h"

namespace mscomp {

using Ink = std::array<std::uint8_t, 3>;  // red, green, blue

/// A place of a picture in whole pixels.
struct Box {
    int left = 0, top = 0, width = 0, height = 0;
};

Image blank_picture(int width, int height);

/// What lies outside the picture is cut off, here and below.
void paste(Image& sheet, const Image& picture, int left, int top);
void fill(Image& sheet, const Box& box, const Ink& ink);
/// The outline of a box, one pixel wide, inside it.
void outline(Image& sheet, const Box& box, const Ink& ink);
/// Mixes everything with light grey.
void wash_out(Image& picture);

}  // namespace mscomp

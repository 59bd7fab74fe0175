// SPDX-License-Identifier: MIT
#pragma once

#include <string_view>

#include "mscomp/render/render.h"

namespace mscomp {

/// Width in pixels of `text` (ASCII) whose capitals are `cap_height` pixels high.
double text_width(std::string_view text, double cap_height);

/// Draws `text` anti-aliased in `gray` (0 = black) with round strokes; (x, baseline) is where its
/// first letter stands. What lies outside the picture is cut off.
void draw_text(Image& image, double x, double baseline, std::string_view text, double cap_height,
               double gray);

/// The longest beginning of `text` that fits into `width`, ending in dots if it is cut.
std::string text_cut_to(std::string_view text, double cap_height, double width);

}  // namespace mscomp

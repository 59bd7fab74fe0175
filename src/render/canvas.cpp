// SPDX-License-Identifier: MIT
#include "canvas.h"

#include <algorithm>

#include "mscomp/base/index.h"

namespace mscomp {

Image blank_picture(int width, int height) {
    return {width, height, std::vector<std::uint8_t>(at(width) * at(height) * 3, 255)};
}

void paste(Image& sheet, const Image& picture, int left, int top) {
    const int begin = std::max(0, -left);
    const int end = std::min(picture.width, sheet.width - left);
    if (begin >= end) return;
    for (int row = std::max(0, -top); row < std::min(picture.height, sheet.height - top); ++row) {
        const auto from =
            picture.rgb.begin() + (static_cast<std::ptrdiff_t>(row) * picture.width + begin) * 3;
        const auto to = (static_cast<std::ptrdiff_t>(top + row) * sheet.width + left + begin) * 3;
        std::copy(from, from + static_cast<std::ptrdiff_t>(end - begin) * 3,
                  sheet.rgb.begin() + to);
    }
}

void fill(Image& sheet, const Box& box, const Ink& ink) {
    const int right = std::min(sheet.width, box.left + box.width);
    const int bottom = std::min(sheet.height, box.top + box.height);
    for (int row = std::max(0, box.top); row < bottom; ++row) {
        for (int column = std::max(0, box.left); column < right; ++column) {
            const auto place = (at(row) * at(sheet.width) + at(column)) * 3;
            for (std::size_t c = 0; c < 3; ++c) sheet.rgb[place + c] = ink[c];
        }
    }
}

void outline(Image& sheet, const Box& box, const Ink& ink) {
    fill(sheet, {box.left, box.top, box.width, 1}, ink);
    fill(sheet, {box.left, box.top + box.height - 1, box.width, 1}, ink);
    fill(sheet, {box.left, box.top, 1, box.height}, ink);
    fill(sheet, {box.left + box.width - 1, box.top, 1, box.height}, ink);
}

void wash_out(Image& picture) {
    for (std::uint8_t& value : picture.rgb) {
        value = static_cast<std::uint8_t>((3 * value + 7 * 236) / 10);
    }
}

}  // namespace mscomp

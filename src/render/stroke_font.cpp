// SPDX-License-Identifier: MIT
#include "stroke_font.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

/// Letters are strokes on a grid: capitals reach from y = 0 to the baseline y = 16, small letters
/// start at y = 6, tails end at y = 22. A stroke is a sign and pairs of digits in base 36 (x then
/// y): '-' straight, '~' rounded with fixed ends, '@' rounded and closed.
constexpr double kCapHeight = 16;
constexpr double kGap = 4.2;
constexpr double kSpace = 5;
constexpr double kStrokeWidth = 1.9;

struct Glyph {
    char letter;
    const char* strokes;
};

constexpr std::array kGlyphs{
    Glyph{'a', "@06868g0g-868g"},
    Glyph{'b', "-000g@06868g0g"},
    Glyph{'c', "~8876060g7g8e"},
    Glyph{'d', "-808g@06868g0g"},
    Glyph{'e', "-0b8b~8b86060g7g8e"},
    Glyph{'f', "~60302g-060666"},
    Glyph{'g', "@06868g0g~868m1m0k"},
    Glyph{'h', "-000g~0b06868g"},
    Glyph{'i', "-060g-0202"},
    Glyph{'j', "~363m0m-3232"},
    Glyph{'k', "-000g-760c-3a8g"},
    Glyph{'l', "~000a0g3g"},
    Glyph{'m', "-060g~0b06666g~6b66c6cg"},
    Glyph{'n', "-060g~0b06868g"},
    Glyph{'o', "@06868g0g"},
    Glyph{'p', "-060m@06868g0g"},
    Glyph{'q', "-868m@06868g0g"},
    Glyph{'r', "-060g~0c0656"},
    Glyph{'s', "~7866060b7b7g1g0e"},
    Glyph{'t', "~212g6g-0666"},
    Glyph{'u', "-868g~060g8g8b"},
    Glyph{'v', "-064g86"},
    Glyph{'w', "-063g669gc6"},
    Glyph{'x', "-068g-860g"},
    Glyph{'y', "-064g-862m"},
    Glyph{'z', "-06860g8g"},
    Glyph{'A', "-0g60cg-2aaa"},
    Glyph{'B', "-000g~00808707-0000~07979g0g"},
    Glyph{'C', "~a390000g9gad"},
    Glyph{'D', "-000g~00a0ag0g"},
    Glyph{'E', "-80000g8g-0777"},
    Glyph{'F', "-80000g-0777"},
    Glyph{'G', "~a390000gaga9-6999a9"},
    Glyph{'H', "-000g-a0ag-08a8"},
    Glyph{'I', "-000g"},
    Glyph{'J', "~606g0g0c"},
    Glyph{'K', "-000g-900a-379g"},
    Glyph{'L', "-000g8g"},
    Glyph{'M', "-0g006cc0cg"},
    Glyph{'N', "-0g00aga0"},
    Glyph{'O', "@00b0bg0g"},
    Glyph{'P', "-0g00~00909909"},
    Glyph{'Q', "@00b0bg0g-7cbh"},
    Glyph{'R', "-0g00~00909909-499g"},
    Glyph{'S', "~93800008989g1g0d"},
    Glyph{'T', "-00a0-505g"},
    Glyph{'U', "~000gaga0"},
    Glyph{'V', "-006gc0"},
    Glyph{'W', "-004g82cgg0"},
    Glyph{'X', "-00ag-a00g"},
    Glyph{'Y', "-0058a0-585g"},
    Glyph{'Z', "-00a00gag"},
    Glyph{'0', "@00909g0g"},
    Glyph{'1', "-03404g"},
    Glyph{'2', "~04009097380g-0g9g"},
    Glyph{'3', "~0300808737~37979g0g0d"},
    Glyph{'4', "-7g700bab"},
    Glyph{'5', "-801007~0746969g0g0d"},
    Glyph{'6', "~8160000b@06969g0g"},
    Glyph{'7', "-00903g"},
    Glyph{'8', "@10808717@07979g0g"},
    Glyph{'9', "@00909a0a~959g3g1f"},
    Glyph{'.', "-0g0g"},
    Glyph{',', "-1g0j"},
    Glyph{':', "-0808-0g0g"},
    Glyph{';', "-1818-1g0j"},
    Glyph{'-', "-0a5a"},
    Glyph{'_', "-0i9i"},
    Glyph{'+', "-0a8a-464e"},
    Glyph{'=', "-0878-0c8c"},
    Glyph{'(', "~30040e3i"},
    Glyph{')', "~00343e0i"},
    Glyph{'[', "-30000i3i"},
    Glyph{']', "-00303i0i"},
    Glyph{'/', "-700i"},
    Glyph{'|', "-000i"},
    Glyph{'%', "@00505606@7acacg7g-b01g"},
    Glyph{'#', "-300g-906g-0595-0bcb"},
    Glyph{'*', "-4149-0378-7308"},
    Glyph{'<', "-650a6f"},
    Glyph{'>', "-056a0f"},
    Glyph{'!', "-000b-0g0g"},
    Glyph{'?', "~0300707648-484b-4g4g"},
    Glyph{'\'', "-0004"},
    Glyph{'"', "-0004-3034"},
    Glyph{'&', "~ag25207076090g7gaa"},
    Glyph{'~', "~0b084c8c89"},
};
/// Signs followed by whole pairs of digits on the grid.
constexpr bool well_formed(const char* strokes) {
    while (*strokes != '\0') {
        const char sign = *strokes++;
        if (sign != '-' && sign != '~' && sign != '@') return false;
        int digits = 0;
        for (; (*strokes >= '0' && *strokes <= '9') || (*strokes >= 'a' && *strokes <= 'm');
             ++strokes) {
            ++digits;
        }
        if (digits < 4 || digits % 2 != 0) return false;
    }
    return true;
}
static_assert(std::all_of(kGlyphs.begin(), kGlyphs.end(),
                          [](const Glyph& glyph) { return well_formed(glyph.strokes); }));

/// Drawn for every character without a glyph.
constexpr const char* kUnknown = "-00808g0g00";

struct Position {
    double x = 0, y = 0;
};
using Stroke = std::vector<Position>;

const char* strokes_of(char letter) {
    for (const Glyph& glyph : kGlyphs) {
        if (glyph.letter == letter) return glyph.strokes;
    }
    return kUnknown;
}

double digit(char c) { return c <= '9' ? c - '0' : c - 'a' + 10; }

/// One round of corner cutting (Chaikin): the limit is a smooth curve.
Stroke with_cut_corners(const Stroke& stroke, bool closed) {
    Stroke cut;
    const std::size_t count = stroke.size();
    if (!closed) cut.push_back(stroke.front());
    for (std::size_t i = 0; i + (closed ? 0 : 1) < count; ++i) {
        const Position& p = stroke[i];
        const Position& q = stroke[(i + 1) % count];
        cut.push_back({0.75 * p.x + 0.25 * q.x, 0.75 * p.y + 0.25 * q.y});
        cut.push_back({0.25 * p.x + 0.75 * q.x, 0.25 * p.y + 0.75 * q.y});
    }
    if (!closed) cut.push_back(stroke.back());
    return cut;
}

Stroke smoothed(Stroke stroke, char sign) {
    if (sign == '-') return stroke;
    const bool closed = sign == '@';
    for (int round = 0; round < 4; ++round) stroke = with_cut_corners(stroke, closed);
    if (closed) stroke.push_back(stroke.front());
    return stroke;
}

std::vector<Stroke> outline(const char* strokes) {
    std::vector<Stroke> result;
    for (const char* c = strokes; *c != '\0';) {
        const char sign = *c++;
        Stroke stroke;
        while ((*c >= '0' && *c <= '9') || (*c >= 'a' && *c <= 'z')) {
            stroke.push_back({digit(c[0]), digit(c[1])});
            c += 2;
        }
        result.push_back(smoothed(std::move(stroke), sign));
    }
    return result;
}

double advance(char letter) {
    if (letter == ' ') return kSpace;
    double width = 0;
    for (const Stroke& stroke : outline(strokes_of(letter))) {
        for (const Position& p : stroke) width = std::max(width, p.x);
    }
    return width + kGap;
}

double distance_to_segment(const Position& p, const Position& a, const Position& b) {
    const double dx = b.x - a.x, dy = b.y - a.y;
    const double square = dx * dx + dy * dy;
    const double along = square > 0 ? ((p.x - a.x) * dx + (p.y - a.y) * dy) / square : 0;
    const double t = std::clamp(along, 0.0, 1.0);
    return std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
}

double distance_to(const std::vector<Stroke>& strokes, const Position& p) {
    double nearest = 1e9;
    for (const Stroke& stroke : strokes) {
        for (std::size_t i = 0; i + 1 < stroke.size(); ++i) {
            nearest = std::min(nearest, distance_to_segment(p, stroke[i], stroke[i + 1]));
        }
    }
    return nearest;
}

void draw_letter(Image& image, double x, double baseline, char letter, double scale, double gray) {
    std::vector<Stroke> strokes = outline(strokes_of(letter));
    double right = x;
    for (Stroke& stroke : strokes) {
        for (Position& p : stroke) {
            p = {x + scale * p.x, baseline + scale * (p.y - kCapHeight)};
            right = std::max(right, p.x);
        }
    }
    const double half_width = std::max(0.5 * scale * kStrokeWidth, 0.45);
    const int top = std::max(0, static_cast<int>(baseline - scale * (kCapHeight + 2)));
    const int bottom = std::min(image.height - 1, static_cast<int>(baseline + scale * 8 + 1));
    const int last = std::min(image.width - 1, static_cast<int>(right + half_width + 1));
    for (int row = top; row <= bottom; ++row) {
        for (int column = std::max(0, static_cast<int>(x - half_width - 1)); column <= last;
             ++column) {
            const double distance = distance_to(strokes, {column + 0.5, row + 0.5});
            const double cover = std::clamp(half_width + 0.5 - distance, 0.0, 1.0);
            if (cover <= 0) continue;
            const auto place = at(row * image.width + column) * 3;
            for (std::size_t c = 0; c < 3; ++c) {
                const double below = image.rgb[place + c];
                image.rgb[place + c] =
                    static_cast<std::uint8_t>(std::lround(below + cover * (255 * gray - below)));
            }
        }
    }
}

}  // namespace

double text_width(std::string_view text, double cap_height) {
    double width = 0;
    for (const char letter : text) width += advance(letter);
    return text.empty() ? 0 : (width - kGap) * cap_height / kCapHeight;
}

void draw_text(Image& image, double x, double baseline, std::string_view text, double cap_height,
               double gray) {
    const double scale = cap_height / kCapHeight;
    for (const char letter : text) {
        if (letter != ' ') draw_letter(image, x, baseline, letter, scale, gray);
        x += advance(letter) * scale;
    }
}

std::string text_cut_to(std::string_view text, double cap_height, double width) {
    if (text_width(text, cap_height) <= width) return std::string(text);
    std::string cut(text);
    while (!cut.empty()) {
        cut.pop_back();
        if (text_width(cut + "...", cap_height) <= width) return cut + "...";
    }
    return cut;
}

}  // namespace mscomp

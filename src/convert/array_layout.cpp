// SPDX-License-Identifier: MIT
#include "array_layout.h"

#include <fmt/format.h>

#include <algorithm>

#include "array_checks.h"

namespace mscomp {
namespace {

/// A way to read an array, and what it is called.
struct Layout {
    Shape shape, strides;  // (N,V,width)
    std::string name;
    bool is_usual = false;  // how an array of as many axes mostly is
};

/// All ways that fit the lengths, (N,V,width) as it is first.
std::vector<Layout> layouts_of(const NpyArray& array, std::int64_t width) {
    const Shape& n = array.shape;
    const Shape& s = array.strides;
    std::vector<Layout> found;
    const auto add_axes = [&](std::size_t shapes, std::size_t vertices, std::size_t numbers,
                              const char* name) {
        if (n[numbers] != width) return;
        found.push_back({{n[shapes], n[vertices], width},
                         {s[shapes], s[vertices], s[numbers]},
                         fmt::format(fmt::runtime(name), width)});
    };
    const auto add_one_shape = [&](std::size_t vertices, std::size_t numbers, const char* name) {
        if (n[numbers] != width) return;
        found.push_back({{1, n[vertices], width},
                         {0, s[vertices], s[numbers]},
                         fmt::format(fmt::runtime(name), width)});
    };
    const auto add_joined = [&](std::size_t shapes, std::size_t numbers, const char* name) {
        if (n[numbers] % width != 0) return;
        found.push_back({{n[shapes], n[numbers] / width, width},
                         {s[shapes], width * s[numbers], s[numbers]},
                         fmt::format(fmt::runtime(name), width)});
    };
    const auto mark_usual = [&] {
        if (!found.empty()) found.front().is_usual = true;
    };
    if (n.size() == 3) {
        add_axes(0, 1, 2, "(N,V,{})");
        mark_usual();
        add_axes(2, 0, 1, "(V,{},N)");
        add_axes(0, 2, 1, "(N,{},V)");
        add_axes(2, 1, 0, "({},V,N)");
    } else if (n.size() == 2) {
        add_one_shape(0, 1, "(V,{})");
        mark_usual();
        add_one_shape(1, 0, "({},V)");
        add_joined(0, 1, "(N,V*{})");
        add_joined(1, 0, "(V*{},N)");
    }
    return found;
}

/// Those that fit the number of vertices; the usual one alone if it is among them.
std::vector<Layout> fitting_layouts(const NpyArray& array, std::int64_t width,
                                    const VertexCount& vertices) {
    std::vector<Layout> layouts = layouts_of(array, width);
    std::erase_if(layouts, [&](const Layout& layout) { return !vertices.allows(layout.shape[1]); });
    if (!layouts.empty() && layouts.front().is_usual) layouts.resize(1);
    return layouts;
}

}  // namespace

bool has_vertex_rows(const NpyArray& array, std::int64_t width, const VertexCount& vertices) {
    return fitting_layouts(array, width, vertices).size() == 1;
}

NpyArray vertex_rows(const NpyArray& array, std::int64_t width, const VertexCount& vertices,
                     std::vector<std::string>& notes) {
    const std::vector<Layout> layouts = fitting_layouts(array, width, vertices);
    if (layouts.size() != 1) {
        require_shape(array.shape, {-1, -1, width}, array.path);
        return array;
    }
    NpyArray rows = array;
    rows.shape = layouts.front().shape;
    rows.strides = layouts.front().strides;
    if (array.shape != rows.shape) {
        notes.push_back(fmt::format("{} {} is read as {}", array.path,
                                    numpy_shape_text(array.shape), layouts.front().name));
    }
    return rows;
}

std::vector<int> face_corners(const NpyArray& array) {
    NpyArray rows = array;
    const bool is_transposed =
        array.shape.size() == 2 && array.shape[0] == 3 && array.shape[1] != 3;
    if (is_transposed) {
        std::swap(rows.shape[0], rows.shape[1]);
        std::swap(rows.strides[0], rows.strides[1]);
    }
    require_shape(rows.shape, {-1, 3}, rows.path);
    return rows.integers();
}

void count_from_zero(std::vector<int>& corners, int vertex_count, std::vector<std::string>& notes) {
    if (corners.empty()) return;
    const auto [lowest, highest] = std::minmax_element(corners.begin(), corners.end());
    if (*lowest < 1 || *highest != vertex_count) return;
    for (int& corner : corners) --corner;
    notes.emplace_back("faces are taken to count from 1");
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/render/error_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "canvas.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

bool is_finite(const std::vector<Point>& points) {
    return std::ranges::all_of(points, [](const Point& p) {
        return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
    });
}

void check(const TriangleMesh& reference, std::span<const ComparedShape> shapes, int columns) {
    if (shapes.empty()) throw UsageError("error sheet: there are no shapes to put on it");
    if (columns < 1) throw UsageError(fmt::format("error sheet: {} columns", columns));
    const std::size_t wanted = reference.vertices.size();
    for (const ComparedShape& shape : shapes) {
        if (shape.truth.size() != wanted || shape.result.size() != wanted ||
            shape.distance.size() != wanted) {
            throw UsageError(fmt::format(
                "error sheet: '{}' has {} vertices, a result of {} and {} distances; wanted {}",
                shape.name, shape.truth.size(), shape.result.size(), shape.distance.size(),
                wanted));
        }
    }
}

std::vector<std::array<float, 3>> colors_of(const ComparedShape& shape, double full) {
    std::vector<std::array<float, 3>> colors;
    for (const double distance : shape.distance) {
        const bool is_shown = full > 0 && std::isfinite(distance);
        colors.push_back(white_to_blue(is_shown ? static_cast<float>(distance / full) : 0.0F));
    }
    return colors;
}

}  // namespace

double largest_distance(std::span<const ComparedShape> shapes) {
    double largest = 0;
    for (const ComparedShape& shape : shapes) {
        for (const double distance : shape.distance) {
            if (std::isfinite(distance)) largest = std::max(largest, distance);
        }
    }
    return largest;
}

Image error_sheet(const TriangleMesh& reference, std::span<const ComparedShape> shapes,
                  const std::string& title, int longer_side, int columns) {
    check(reference, shapes, columns);
    std::vector<Point> all;
    for (const ComparedShape& shape : shapes) {
        all.insert(all.end(), shape.truth.begin(), shape.truth.end());
        if (is_finite(shape.result)) {
            all.insert(all.end(), shape.result.begin(), shape.result.end());
        }
    }
    View view = framed(fit_view(reference.vertices), all);
    const auto [width, height] = picture_size(view, longer_side);
    view = framed(view, all, static_cast<double>(width) / height);

    const double full = largest_distance(shapes);
    std::vector<SheetTile> tiles;
    for (const ComparedShape& shape : shapes) {
        tiles.push_back(
            {render_mesh({shape.truth, reference.faces}, {}, view, width, height), shape.name, 0});
        if (!is_finite(shape.result)) {
            tiles.push_back({blank_picture(width, height), "not finite", 0});
            continue;
        }
        tiles.push_back({render_mesh({shape.result, reference.faces}, colors_of(shape, full), view,
                                     width, height),
                         shape.remark, 0});
    }
    // The scale first: a narrow sheet cuts off the end.
    const std::string heading =
        fmt::format("Distance: white 0, blue {:.3g} (every result is right of its truth)", full);
    return contact_sheet(tiles, {heading}, title, 2 * columns);
}

}  // namespace mscomp

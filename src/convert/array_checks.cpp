// SPDX-License-Identifier: MIT
#include "array_checks.h"

#include <fmt/format.h>

#include <limits>

#include "mscomp/base/error.h"
#include "mscomp/convert/npy.h"

namespace mscomp {

void require_shape(const Shape& shape, const Shape& wanted, const std::string& path) {
    bool is_wanted = shape.size() == wanted.size();
    std::string text;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        is_wanted = is_wanted && (wanted[i] == -1 || shape[i] == wanted[i]);
        text += fmt::format("{}{}", i == 0 ? "" : ", ",
                            wanted[i] == -1 ? "any" : fmt::format("{}", wanted[i]));
    }
    if (is_wanted) return;
    throw InputError({path},
                     fmt::format("has the shape {}, wanted ({})", numpy_shape_text(shape), text));
}

void require_counts(std::int64_t shapes, std::int64_t vertices, const std::string& path) {
    constexpr std::int64_t most = std::numeric_limits<int>::max();
    if (shapes > 0 && vertices > 0 && shapes <= most && vertices <= most) return;
    throw InputError(
        {path}, fmt::format("has {} shapes of {} vertices, wanted 1 to 2^31 - 1 of both", shapes,
                            vertices));
}

std::vector<Face> checked_faces(const std::vector<int>& corners, int vertex_count,
                                const std::string& path) {
    if (corners.empty()) throw InputError({path}, "has no faces");
    std::vector<Face> faces(corners.size() / 3);
    for (std::size_t i = 0; i < 3 * faces.size(); ++i) {
        if (corners[i] < 0 || corners[i] >= vertex_count) {
            throw InputError({path}, fmt::format("face {} refers to vertex {}, wanted 0 to {}",
                                                 i / 3, corners[i], vertex_count - 1));
        }
        faces[i / 3][i % 3] = corners[i];
    }
    return faces;
}

std::vector<Point> points_of(const std::vector<double>& numbers) {
    std::vector<Point> points(numbers.size() / 3);
    for (std::size_t i = 0; i < 3 * points.size(); ++i) points[i / 3][i % 3] = numbers[i];
    return points;
}

}  // namespace mscomp

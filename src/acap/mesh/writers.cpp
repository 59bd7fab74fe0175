// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <optional>
#include <stdexcept>

#include "float_range.h"
#include "mesh_format.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/output_folder.h"

namespace mscomp {
namespace {

/// No reader should have to cope with what ours refuses.
void check_finite(const std::string& path, const TriangleMesh& mesh) {
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        for (const double x : mesh.vertices[i]) {
            if (std::isfinite(x)) continue;
            throw NumericalError(
                fmt::format("{}: vertex {} (counting from 1) is not finite; nothing was written",
                            final_name(path), i + 1));
        }
    }
}

void check_fits_float(const std::string& path, const TriangleMesh& mesh) {
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        for (const double x : mesh.vertices[i]) {
            if (std::isfinite(static_cast<float>(x))) continue;
            throw NumericalError(fmt::format(
                "{}: vertex {} (counting from 1) has a coordinate of {}, a PLY in float32 holds up "
                "to 3.4e38; nothing was written",
                final_name(path), i + 1, x));
        }
    }
}

template <class T>
void append(std::string& bytes, T value) {
    static_assert(std::endian::native == std::endian::little, "the file is little-endian");
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes.append(raw, sizeof(T));
}

std::string ply_header(const TriangleMesh& mesh, bool doubles, bool colors, bool quality) {
    std::string text = fmt::format(
        "ply\nformat binary_little_endian 1.0\nelement vertex {0}\nproperty {1} x\nproperty {1} "
        "y\nproperty {1} z\n",
        mesh.vertex_count(), doubles ? "double" : "float");
    if (colors) text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    if (quality) text += "property float quality\n";
    return text +=
           fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                       mesh.face_count());
}

/// How far from the origin the vertices lie that faces use, in sizes: the others would hide it.
double distance_of_surface(const TriangleMesh& mesh) {
    std::vector<char> used(mesh.vertices.size(), 0);
    for (const Face& face : mesh.faces) {
        for (const int corner : face) used[at(corner)] = 1;
    }
    std::vector<Point> surface;
    surface.reserve(mesh.vertices.size());
    for (std::size_t i = 0; i < used.size(); ++i) {
        if (used[i] != 0) surface.push_back(mesh.vertices[i]);
    }
    return distance_from_origin(surface);
}

/// Nine digits tell any two floats apart; further away from the origin it takes one more for every
/// factor of ten. Seventeen hold any double.
int digits_for(const TriangleMesh& mesh) {
    constexpr double kNear = 10;
    const double distance = distance_of_surface(mesh);
    if (!(distance > kNear)) return 9;
    return static_cast<int>(std::min(17.0, 9 + std::ceil(std::log10(distance))));
}

bool needs_doubles(const TriangleMesh& mesh) { return distance_of_surface(mesh) > kFarFromOrigin; }

void append_position(std::string& text, const Point& point, int digits) {
    fmt::format_to(std::back_inserter(text), "{:.{}g} {:.{}g} {:.{}g}\n", point[0], digits,
                   point[1], digits, point[2], digits);
}

double read_back(double number, int digits) {
    const std::string text = fmt::format("{:.{}g}", number, digits);
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
}

}  // namespace

void write_obj(const std::string& path, const TriangleMesh& mesh) {
    check_finite(path, mesh);
    std::string text;
    text.reserve(mesh.vertices.size() * 40 + mesh.faces.size() * 24);
    const int digits = digits_for(mesh);
    for (const Point& point : mesh.vertices) {
        text += "v ";
        append_position(text, point, digits);
    }
    for (const auto& [a, b, c] : mesh.faces) {
        fmt::format_to(std::back_inserter(text), "f {} {} {}\n", a + 1, b + 1, c + 1);
    }
    write_file(path, text);
}

void write_off(const std::string& path, const TriangleMesh& mesh) {
    check_finite(path, mesh);
    std::string text = fmt::format("OFF\n{} {} 0\n", mesh.vertex_count(), mesh.face_count());
    text.reserve(text.size() + mesh.vertices.size() * 40 + mesh.faces.size() * 24);
    const int digits = digits_for(mesh);
    for (const Point& point : mesh.vertices) append_position(text, point, digits);
    for (const auto& [a, b, c] : mesh.faces) {
        fmt::format_to(std::back_inserter(text), "3 {} {} {}\n", a, b, c);
    }
    write_file(path, text);
}

void write_ply(const std::string& path, const TriangleMesh& mesh,
               std::span<const VertexColor> colors, std::span<const float> quality) {
    const std::size_t count = mesh.vertices.size();
    if ((!colors.empty() && colors.size() != count) ||
        (!quality.empty() && quality.size() != count)) {
        throw std::logic_error("write_ply: wanted one color and one quality for every vertex");
    }
    check_finite(path, mesh);
    check_fits_float(path, mesh);
    const bool doubles = needs_doubles(mesh);
    std::string bytes = ply_header(mesh, doubles, !colors.empty(), !quality.empty());
    bytes.reserve(bytes.size() + count * (doubles ? 31 : 19) + mesh.faces.size() * 13);
    for (std::size_t i = 0; i < count; ++i) {
        for (const double x : mesh.vertices[i]) {
            if (doubles) {
                append(bytes, x);
            } else {
                append(bytes, static_cast<float>(x));
            }
        }
        if (!colors.empty()) {
            append(bytes, colors[i].red);
            append(bytes, colors[i].green);
            append(bytes, colors[i].blue);
        }
        if (!quality.empty()) append(bytes, quality[i]);
    }
    for (const Face& face : mesh.faces) {
        append(bytes, std::uint8_t{3});
        for (const int corner : face) append(bytes, corner);
    }
    write_file(path, bytes);
}

void write_mesh(const std::string& path, const TriangleMesh& mesh) {
    const std::optional<MeshFormat> format = mesh_format(path);
    if (!format)
        throw UsageError(fmt::format("{}: {}", final_name(path), extension_complaint(path)));
    switch (*format) {
        case MeshFormat::obj:
            return write_obj(path, mesh);
        case MeshFormat::ply:
            return write_ply(path, mesh);
        case MeshFormat::off:
            return write_off(path, mesh);
    }
}

std::vector<Point> as_written(const std::string& path, const TriangleMesh& mesh) {
    const bool is_ply = mesh_format(path) == MeshFormat::ply;
    const bool doubles = is_ply && needs_doubles(mesh);
    const int digits = is_ply ? 0 : digits_for(mesh);
    std::vector<Point> result = mesh.vertices;
    if (doubles) return result;
    for (Point& point : result) {
        for (double& x : point) {
            x = is_ply ? static_cast<double>(static_cast<float>(x)) : read_back(x, digits);
        }
    }
    return result;
}

}  // namespace mscomp

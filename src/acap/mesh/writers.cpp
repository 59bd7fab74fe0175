// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <optional>
#include <stdexcept>

#include "mesh_format.h"
#include "mscomp/acap/mesh/mesh_io.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
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

std::string ply_header(const TriangleMesh& mesh, bool colors, bool quality) {
    std::string text = fmt::format(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float "
        "y\nproperty float z\n",
        mesh.vertex_count());
    if (colors) text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    if (quality) text += "property float quality\n";
    return text +=
           fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n",
                       mesh.face_count());
}

/// Nine digits tell any two floats apart.
void append_position(std::string& text, const Point& point) {
    fmt::format_to(std::back_inserter(text), "{:.9g} {:.9g} {:.9g}\n", point[0], point[1],
                   point[2]);
}

}  // namespace

void write_obj(const std::string& path, const TriangleMesh& mesh) {
    check_finite(path, mesh);
    std::string text;
    text.reserve(mesh.vertices.size() * 40 + mesh.faces.size() * 24);
    for (const Point& point : mesh.vertices) {
        text += "v ";
        append_position(text, point);
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
    for (const Point& point : mesh.vertices) append_position(text, point);
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
    std::string bytes = ply_header(mesh, !colors.empty(), !quality.empty());
    bytes.reserve(bytes.size() + count * 19 + mesh.faces.size() * 13);
    for (std::size_t i = 0; i < count; ++i) {
        for (const double x : mesh.vertices[i]) append(bytes, static_cast<float>(x));
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

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "number_text.h"
#include "ply_header.h"
#include "ply_rows.h"
#include "polygon_mesh.h"

namespace mscomp {
namespace {

constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};

bool is_corner_list(const PlyProperty& property) {
    return property.count_type.has_value() &&
           (property.name == "vertex_indices" || property.name == "vertex_index");
}

std::string element_names(const PlyHeader& header) {
    std::string names;
    for (const PlyElement& element : header.elements) {
        names += fmt::format("{}{}", names.empty() ? "" : ", ", in_quotes(element.name));
    }
    return names.empty() ? "none" : names;
}

const PlyElement& find_element(const PlyHeader& header, std::string_view name,
                               const std::string& path) {
    const PlyElement* found = nullptr;
    for (const PlyElement& element : header.elements) {
        if (element.name == "tristrips") {
            throw InputError({path, element.line},
                             "got triangle strips ('tristrips'), expected an element 'face'; save "
                             "the mesh with single faces");
        }
        if (element.name != name) continue;
        if (found != nullptr) {
            throw InputError({path, element.line},
                             fmt::format("got a second element '{}', expected one", name));
        }
        found = &element;
    }
    if (found != nullptr) return *found;
    throw InputError({path},
                     fmt::format("has no element '{}', only {}", name, element_names(header)));
}

/// Which of x, y, z every property of the vertex is, or 3.
std::vector<std::size_t> axes_of(const PlyElement& vertex, const std::string& path) {
    std::vector<std::size_t> axes(vertex.properties.size(), 3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        std::size_t found = 0;
        for (std::size_t i = 0; i < axes.size(); ++i) {
            const PlyProperty& property = vertex.properties[i];
            if (property.name != kAxes[axis] || property.count_type) continue;
            axes[i] = axis;
            ++found;
        }
        if (found != 1) {
            throw InputError({path, vertex.line},
                             fmt::format("got {} properties '{}' of the vertex, expected one",
                                         found, kAxes[axis]));
        }
    }
    return axes;
}

void check_face_element(const PlyElement& face, const std::string& path) {
    std::size_t found = 0;
    for (const PlyProperty& property : face.properties) {
        if (!is_corner_list(property)) continue;
        ++found;
        if (!is_integer(property.type)) {
            throw InputError({path, face.line},
                             fmt::format("'{}' holds no integers", property.name));
        }
    }
    if (found != 1) {
        throw InputError({path, face.line},
                         fmt::format("got {} lists 'vertex_indices' or 'vertex_index' of the face, "
                                     "expected one",
                                     found));
    }
}

template <class Rows>
class PlyReader {
  public:
    PlyReader(const PlyHeader& header, const std::string& path, Rows rows)
        : header_(header), path_(path), rows_(rows) {}

    PolygonMesh read() {
        const PlyElement& vertex = find_element(header_, "vertex", path_);
        const PlyElement& face = find_element(header_, "face", path_);
        vertex_count_ = vertex.count;
        const std::vector<std::size_t> axes = axes_of(vertex, path_);
        check_face_element(face, path_);
        if (vertex.count == 0) throw InputError({path_, vertex.line}, "has no vertices");
        if (face.count == 0) throw InputError({path_, face.line}, "has no faces");
        if (vertex.count > std::numeric_limits<int>::max()) {
            throw InputError({path_, vertex.line}, "has more than 2^31 - 1 vertices");
        }
        mesh_.vertices.reserve(at(vertex.count));
        mesh_.ends.reserve(at(face.count));
        for (const PlyElement& element : header_.elements) {
            // Rows without properties take no bytes, however many the header claims.
            if (element.properties.empty()) continue;
            for (std::int64_t i = 0; i < element.count; ++i) {
                rows_.begin_row(element, i);
                if (&element == &vertex) {
                    read_vertex(element, axes);
                } else {
                    read_row(element, &element == &face);
                }
                rows_.end_row();
            }
        }
        rows_.end_file();
        return std::move(mesh_);
    }

  private:
    void read_vertex(const PlyElement& vertex, const std::vector<std::size_t>& axes) {
        Point point{};
        for (std::size_t i = 0; i < axes.size(); ++i) {
            const PlyProperty& property = vertex.properties[i];
            if (axes[i] == 3) {
                skip(property);
                continue;
            }
            const double value = rows_.value(property.type, kCoordinates[axes[i]]);
            if (!std::isfinite(value)) {
                rows_.fail(fmt::format("{}: got '{}', expected a finite number",
                                       kCoordinates[axes[i]], value));
            }
            point[axes[i]] = value;
        }
        mesh_.vertices.push_back(point);
    }

    void read_row(const PlyElement& element, bool is_face) {
        for (const PlyProperty& property : element.properties) {
            if (is_face && is_corner_list(property)) {
                read_corners(property);
            } else {
                skip(property);
            }
        }
    }

    void read_corners(const PlyProperty& property) {
        const std::int64_t count = read_list_length(property);
        if (count < 3) {
            rows_.fail(fmt::format("got a face with {} corners, expected at least 3", count));
        }
        for (std::int64_t i = 0; i < count; ++i) {
            const double corner = rows_.value(property.type, "a corner of the face");
            if (!(corner >= 0 && corner < static_cast<double>(vertex_count_))) {
                rows_.fail(fmt::format("face refers to vertex {}, the file has {} (0 to {})",
                                       corner, vertex_count_, vertex_count_ - 1));
            }
            mesh_.corners.push_back(static_cast<int>(corner));
        }
        mesh_.ends.push_back(mesh_.corners.size());
    }

    void skip(const PlyProperty& property) {
        const std::int64_t count = property.count_type ? read_list_length(property) : 1;
        for (std::int64_t i = 0; i < count; ++i) rows_.value(property.type, property.name);
    }

    std::int64_t read_list_length(const PlyProperty& property) {
        const double length = rows_.value(*property.count_type, "the length of " + property.name);
        if (!(length >= 0 && length <= static_cast<double>(rows_.bytes_left()))) {
            rows_.fail(
                fmt::format("got a list '{}' of {} values, expected no more than fit the {} "
                            "bytes left",
                            property.name, length, rows_.bytes_left()));
        }
        return static_cast<std::int64_t>(length);
    }

    const PlyHeader& header_;
    const std::string& path_;
    Rows rows_;
    std::int64_t vertex_count_ = 0;
    PolygonMesh mesh_;
};

template <class Rows>
PolygonMesh read_rows(std::string_view bytes, const PlyHeader& header, const std::string& path) {
    return PlyReader<Rows>(header, path, Rows(bytes, header, path)).read();
}

}  // namespace

PolygonMesh parse_ply_polygons(std::string_view bytes, const std::string& path) {
    const PlyHeader header = parse_ply_header(bytes, path);
    switch (header.format) {
        case PlyFormat::ascii:
            return read_rows<PlyTextRows>(bytes, header, path);
        case PlyFormat::little_endian:
            return read_rows<PlyByteRows<std::endian::native == std::endian::big>>(bytes, header,
                                                                                   path);
        case PlyFormat::big_endian:
            return read_rows<PlyByteRows<std::endian::native == std::endian::little>>(bytes, header,
                                                                                      path);
    }
    return {};
}

}  // namespace mscomp

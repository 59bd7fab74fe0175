// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
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
           (same_word(property.name, "vertex_indices") || same_word(property.name, "vertex_index"));
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
        if (same_word(element.name, "tristrips")) {
            throw InputError({path, element.line},
                             "got triangle strips ('tristrips'), expected an element 'face'; save "
                             "the mesh with single faces");
        }
        if (!same_word(element.name, name)) continue;
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

/// Which properties of the vertex are called `name`: as it is written or, if none is, in any case.
std::vector<std::size_t> properties_called(const PlyElement& vertex, std::string_view name) {
    std::vector<std::size_t> exactly, in_any_case;
    for (std::size_t i = 0; i < vertex.properties.size(); ++i) {
        const PlyProperty& property = vertex.properties[i];
        if (property.count_type) continue;
        if (property.name == name) exactly.push_back(i);
        if (same_word(property.name, name)) in_any_case.push_back(i);
    }
    return exactly.empty() ? in_any_case : exactly;
}

std::string property_names(const PlyElement& element) {
    std::string names;
    for (const PlyProperty& property : element.properties) {
        names += fmt::format("{}{}", names.empty() ? "" : ", ", in_quotes(property.name));
    }
    return names.empty() ? "none" : names;
}

/// Which of x, y, z every property of the vertex is, or 3.
std::vector<std::size_t> axes_of(const PlyElement& vertex, const std::string& path) {
    std::vector<std::size_t> axes(vertex.properties.size(), 3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::vector<std::size_t> found = properties_called(vertex, kAxes[axis]);
        if (found.size() != 1) {
            throw InputError(
                {path, vertex.line},
                fmt::format("got {} properties '{}' of the vertex, expected one; it has {}",
                            found.size(), kAxes[axis], property_names(vertex)));
        }
        axes[found.front()] = axis;
    }
    return axes;
}

/// What a property of the vertex is called for people.
std::string name_for_people(const std::string& property) {
    const auto is_one_of = [&](std::initializer_list<std::string_view> names) {
        return std::any_of(names.begin(), names.end(),
                           [&](std::string_view name) { return same_word(property, name); });
    };
    if (is_one_of({"nx", "ny", "nz"})) return "normals";
    if (is_one_of({"red", "green", "blue", "alpha", "r", "g", "b", "a"})) return "vertex colours";
    if (is_one_of({"s", "t", "u", "v", "texture_u", "texture_v"})) return "texture coordinates";
    return fmt::format("the property {} of the vertices", in_quotes(property));
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
        note_unused(vertex, face, axes);
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
        if (mesh_.ends.empty()) {
            throw InputError({path_, face.line}, "has no faces of three corners or more");
        }
        return std::move(mesh_);
    }

  private:
    void note_unused(const PlyElement& vertex, const PlyElement& face,
                     const std::vector<std::size_t>& axes) {
        for (std::size_t i = 0; i < axes.size(); ++i) {
            if (axes[i] == 3) mesh_.leave_unused(name_for_people(vertex.properties[i].name));
        }
        for (const PlyProperty& property : face.properties) {
            if (is_corner_list(property)) continue;
            mesh_.leave_unused(
                fmt::format("the property {} of the faces", in_quotes(property.name)));
        }
        for (const PlyElement& element : header_.elements) {
            if (&element == &vertex || &element == &face || element.count == 0) continue;
            mesh_.leave_unused(fmt::format("the elements {}", in_quotes(element.name)));
        }
    }

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
        for (std::int64_t i = 0; i < count; ++i) {
            const double corner = rows_.value(property.type, "a corner of the face");
            if (!(corner >= 0 && corner < static_cast<double>(vertex_count_))) {
                rows_.fail(fmt::format("face refers to vertex {}, the file has {} (0 to {})",
                                       corner, vertex_count_, vertex_count_ - 1));
            }
            mesh_.corners.push_back(static_cast<int>(corner));
        }
        mesh_.finish_face([&] { return rows_.place(); });
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

/// Line by line, or as one stream of numbers if that fails and the stream makes exactly what the
/// header promises; the error is that of the lines.
PolygonMesh read_text(std::string_view bytes, const PlyHeader& header, const std::string& path) {
    try {
        return read_rows<PlyTextRows<false>>(bytes, header, path);
    } catch (const InputError&) {
        try {
            return read_rows<PlyTextRows<true>>(bytes, header, path);
        } catch (const InputError&) {
        }
        throw;
    }
}

}  // namespace

PolygonMesh parse_ply_polygons(std::string_view bytes, const std::string& path) {
    const PlyHeader header = parse_ply_header(bytes, path);
    switch (header.format) {
        case PlyFormat::ascii:
            return read_text(bytes, header, path);
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

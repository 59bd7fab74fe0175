// SPDX-License-Identifier: MIT
#define TINYOBJLOADER_USE_DOUBLE
#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>

#include <sstream>
#include <stdexcept>

#include "mesh/other_readers.h"

namespace mscomp {
namespace {

struct Parsed {
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> objects;
};

Parsed parsed(const std::string& text) {
    Parsed result;
    std::vector<tinyobj::material_t> materials;
    std::string warning, error;
    std::istringstream stream(text);
    if (!tinyobj::LoadObj(&result.attributes, &result.objects, &materials, &warning, &error,
                          &stream, nullptr, false)) {
        throw std::runtime_error("tinyobjloader: " + error);
    }
    return result;
}

}  // namespace

OtherMesh read_with_tinyobjloader(const std::string& text) {
    const auto [attributes, objects] = parsed(text);
    OtherMesh result;
    for (std::size_t i = 0; i + 2 < attributes.vertices.size(); i += 3) {
        result.vertices.push_back(
            {attributes.vertices[i], attributes.vertices[i + 1], attributes.vertices[i + 2]});
    }
    for (const tinyobj::shape_t& object : objects) {
        std::size_t at = 0;
        for (const auto count : object.mesh.num_face_vertices) {
            result.faces.emplace_back();
            for (std::size_t i = 0; i < count; ++i) {
                result.faces.back().push_back(object.mesh.indices[at++].vertex_index);
            }
        }
    }
    return result;
}

std::size_t parse_with_tinyobjloader(const std::string& text) {
    std::size_t count = 0;
    for (const auto& object : parsed(text).objects) count += object.mesh.num_face_vertices.size();
    return count;
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <sstream>
#include <stdexcept>

#include "mesh/other_readers.h"

namespace mscomp {
namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
    using Point = OpenMesh::Vec3d;
    using Normal = OpenMesh::Vec3d;
};

using Mesh = OpenMesh::PolyMesh_ArrayKernelT<DoubleTraits>;

Mesh parsed(const std::string& bytes, const std::string& extension) {
    Mesh mesh;
    std::istringstream stream(bytes);
    OpenMesh::IO::Options options;
    if (bytes.find("format binary") < 40) options += OpenMesh::IO::Options::Binary;
    if (!OpenMesh::IO::read_mesh(mesh, stream, extension, options)) {
        throw std::runtime_error("OpenMesh did not read the mesh");
    }
    return mesh;
}

}  // namespace

OtherMesh read_with_openmesh(const std::string& bytes, const std::string& extension) {
    const Mesh mesh = parsed(bytes, extension);
    OtherMesh result;
    for (const auto vertex : mesh.vertices()) {
        const OpenMesh::Vec3d p = mesh.point(vertex);
        result.vertices.push_back({p[0], p[1], p[2]});
    }
    for (const auto face : mesh.faces()) {
        result.faces.emplace_back();
        for (const auto vertex : face.vertices()) result.faces.back().push_back(vertex.idx());
    }
    return result;
}

std::size_t parse_with_openmesh(const std::string& bytes, const std::string& extension) {
    return parsed(bytes, extension).n_faces();
}

}  // namespace mscomp

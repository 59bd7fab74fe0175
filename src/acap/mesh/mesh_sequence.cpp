// SPDX-License-Identifier: MIT
#include "mscomp/acap/mesh/mesh_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <optional>

#include "face_comparison.h"
#include "mscomp/acap/mesh/shape_source.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "polygon_mesh.h"
#include "polygon_split.h"
#include "reading_notes.h"

namespace mscomp {
namespace {

std::string corners_text(std::span<const int> face) {
    constexpr std::size_t longest = 12;
    std::string text;
    for (const int corner : face.first(std::min(face.size(), longest))) {
        text += fmt::format("{}{}", text.empty() ? "" : " ", corner + 1);
    }
    return "(" + text + (face.size() > longest ? " ...)" : ")");
}

class ReferenceConnectivity {
  public:
    ReferenceConnectivity(const PolygonMesh& mesh, std::string path)
        : mesh_(mesh), path_(std::move(path)) {}

    /// Throws InputError unless `mesh` has the vertex count and the faces of the reference.
    void check(const PolygonMesh& mesh, const std::string& path) const {
        if (mesh.vertices.size() != mesh_.vertices.size()) {
            throw InputError({path}, fmt::format("{} vertices, but {} has {}", mesh.vertices.size(),
                                                 path_, mesh_.vertices.size()));
        }
        if (mesh.ends == mesh_.ends && mesh.corners == mesh_.corners) return;
        const SortedFaces faces(mesh);
        if (const auto extra = faces.first_missing_in(sorted_faces())) {
            throw InputError(
                {path}, count_text(mesh) + fmt::format("face {} is {}, which {} does not have{}",
                                                       mesh.file_number(*extra),
                                                       corners_text(mesh.face(*extra)), path_,
                                                       own_face_text(*extra)));
        }
        if (mesh.face_count() == mesh_.face_count()) return;  // as many, and none is another
        if (const auto missing = sorted_faces().first_missing_in(faces)) {
            throw InputError(
                {path}, count_text(mesh) + fmt::format("face {} of {} is {}, which is missing here",
                                                       mesh_.file_number(*missing), path_,
                                                       corners_text(mesh_.face(*missing))));
        }
    }

  private:
    /// Only needed once some file has its faces in another order.
    const SortedFaces& sorted_faces() const {
        std::call_once(once_, [&] { sorted_faces_.emplace(mesh_); });
        return *sorted_faces_;
    }
    std::string count_text(const PolygonMesh& mesh) const {
        if (mesh.face_count() == mesh_.face_count()) return "other faces than " + path_ + ": ";
        return fmt::format("{} faces, but {} has {}: ", mesh.face_count(), path_,
                           mesh_.face_count());
    }
    std::string own_face_text(std::size_t index) const {
        if (index >= mesh_.face_count()) return "";
        return fmt::format(" (there face {} is {})", mesh_.file_number(index),
                           corners_text(mesh_.face(index)));
    }

    const PolygonMesh& mesh_;
    std::string path_;
    mutable std::once_flag once_;
    mutable std::optional<SortedFaces> sorted_faces_;
};

}  // namespace

struct MeshFiles::State {
    State(std::vector<std::string> files, int index)
        : paths(std::move(files)),
          names(shape_names(paths)),
          first(read_polygons(paths.front())),
          connectivity(first, paths.front()) {
        notes.add(0, first);
        split = split_into_triangles(first, index == 0 ? first.vertices : shape(index));
    }

    std::vector<Point> shape(int index) {
        if (index == 0) return first.vertices;
        const std::string& path = paths[at(index)];
        PolygonMesh mesh = read_polygons(path);
        connectivity.check(mesh, path);
        notes.add(index, mesh);
        return std::move(mesh.vertices);
    }

    std::vector<std::string> paths, names;
    PolygonMesh first;
    ReferenceConnectivity connectivity;
    ReadingNotes notes;
    SplitFaces split;  // one for all
};

MeshFiles::MeshFiles(std::vector<std::string> paths, int reference) {
    if (paths.empty()) throw UsageError("no mesh files given");
    state_ = std::make_unique<State>(std::move(paths), reference);
}
MeshFiles::MeshFiles(MeshFiles&&) noexcept = default;
MeshFiles& MeshFiles::operator=(MeshFiles&&) noexcept = default;
MeshFiles::~MeshFiles() = default;

const std::vector<std::string>& MeshFiles::paths() const { return state_->paths; }
const std::vector<std::string>& MeshFiles::names() const { return state_->names; }
const std::vector<Face>& MeshFiles::faces() const { return state_->split.faces; }
std::vector<int> MeshFiles::face_numbers() const { return state_->split.face_numbers; }
int MeshFiles::vertex_count() const { return static_cast<int>(state_->first.vertices.size()); }
std::vector<Point> MeshFiles::shape(int index) const { return state_->shape(index); }
std::vector<std::string> MeshFiles::warnings() const {
    return state_->notes.warnings(state_->paths);
}
std::vector<std::string> MeshFiles::unused() const { return state_->notes.unused(); }

MeshSequence read_sequence(const std::vector<std::string>& paths) {
    const MeshFiles files(paths);
    MeshSequence sequence;
    sequence.names = files.names();
    sequence.faces = files.faces();
    sequence.shapes.resize(paths.size());
    parallel_for(files.shape_count(), [&](std::int64_t i) {
        sequence.shapes[at(i)] = files.shape(static_cast<int>(i));
    });
    return sequence;
}

}  // namespace mscomp

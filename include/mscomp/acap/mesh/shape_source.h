// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/base/index.h"
#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// N shapes of one connectivity, each read when it is asked for, so that a set larger than memory
/// can be worked through.
class ShapeSource {
  public:
    virtual ~ShapeSource() = default;

    virtual const std::vector<std::string>& names() const = 0;  // (N) all different
    virtual const std::vector<Face>& faces() const = 0;         // (F)
    virtual int vertex_count() const = 0;
    /// (F) which face of its file, from 1, every triangle is of; empty where each is its own.
    virtual std::vector<int> face_numbers() const { return {}; }
    /// What was passed over in the shapes read so far, one sentence for each kind: how often, and
    /// where first.
    virtual std::vector<std::string> warnings() const { return {}; }
    /// What the shapes read so far hold besides positions and triangles: "normals".
    virtual std::vector<std::string> unused() const { return {}; }
    /// (V) positions of shape `index`. Safe to call from several threads. Throws IoError or
    /// InputError if it cannot be read or has another connectivity.
    virtual std::vector<Point> shape(int index) const = 0;

    int shape_count() const { return static_cast<int>(names().size()); }
};

/// Mesh files of one connectivity: only the first is held, the others are read and compared with it
/// (same V, same faces; the order of faces and the starting corner may differ) whenever asked for.
/// Polygons are split along inner diagonals of the reference, in the same way for all shapes.
class MeshFiles final : public ShapeSource {
  public:
    /// Reads the first file and that of index `reference`. Throws UsageError if there is none,
    /// IoError or InputError.
    explicit MeshFiles(std::vector<std::string> paths, int reference = 0);
    MeshFiles(MeshFiles&&) noexcept;
    MeshFiles& operator=(MeshFiles&&) noexcept;
    ~MeshFiles() override;

    const std::vector<std::string>& paths() const;
    const std::vector<std::string>& names() const override;
    const std::vector<Face>& faces() const override;
    int vertex_count() const override;
    std::vector<int> face_numbers() const override;
    std::vector<Point> shape(int index) const override;
    std::vector<std::string> warnings() const override;
    std::vector<std::string> unused() const override;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// A sequence in memory, borrowed.
class SequenceSource final : public ShapeSource {
  public:
    explicit SequenceSource(const MeshSequence& sequence) : sequence_(sequence) {}

    const std::vector<std::string>& names() const override { return sequence_.names; }
    const std::vector<Face>& faces() const override { return sequence_.faces; }
    int vertex_count() const override { return sequence_.vertex_count(); }
    std::vector<Point> shape(int index) const override { return sequence_.shapes[at(index)]; }

  private:
    const MeshSequence& sequence_;
};

}  // namespace mscomp

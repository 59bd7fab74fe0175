// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "mscomp/edit/row_positions.h"
#include "mscomp/model/model_file.h"
#include "mscomp/render/render.h"

namespace mscomp {

/// A mesh with an amount per vertex (V) that colours it from white at 0 to blue; without any it is
/// white.
struct ColoredShape {
    TriangleMesh mesh;
    std::vector<float> amount;
    float full_blue = 0;  // the amount drawn in full colour
};

/// Meshes of what differs from the reference by a given change, in the rows of a model: on its W
/// places, until they are made whole for a file.
class ComponentMeshes {
  public:
    /// Borrows the context; `rows` are those of the model (ShapeModel::rows).
    ComponentMeshes(const ModelContext& context, ShapeRows rows);

    /// The mesh whose rows are those of the reference plus `change`. Features do not say where a
    /// mesh lies: of each connected component the largest piece that `change` leaves alone stays,
    /// by the median of its displacements. Components of which it leaves nothing alone keep the
    /// place that RowPositions gives them, beside the one with the largest such piece; where there
    /// is none, the median of all vertices stays.
    TriangleMesh mesh(std::span<const float> change) const;
    /// The same, coloured by |change| at each vertex, full from the 98th percentile of the vertices
    /// that change: a few folded ones can be far above all others.
    ColoredShape colored(std::span<const float> change) const;
    /// How far each vertex of `mesh` is from its place in the reference, in the unit of the mesh.
    std::vector<float> displacement(const TriangleMesh& mesh) const;

    /// With all vertices of the files; those without a place have no amount.
    TriangleMesh whole(const TriangleMesh& mesh) const { return context_.whole(mesh.vertices); }
    ColoredShape whole(const ColoredShape& shape) const;

  private:
    std::vector<float> reference_rows() const;
    void keep_still(TriangleMesh& mesh, const std::vector<float>& amount) const;

    const ModelContext& context_;
    const TriangleMesh& reference_;
    std::vector<int> parts_;  // connected component of every vertex
    RowPositions positions_;
};

/// (V) red, green and blue in [0, 1].
std::vector<std::array<float, 3>> colors_of(const ColoredShape& shape);

/// A PLY with colours, and the amounts as quality. Throws as write_ply.
void write_colored_ply(const std::string& path, const ColoredShape& shape);

/// One view for several pictures: the direction that suits the reference, wide enough for every
/// shape.
struct SheetView {
    View view;
    int width = 0, height = 0;  // of one picture, in pixels
};
SheetView common_view(const TriangleMesh& reference, std::span<const ColoredShape> shapes,
                      int longer_side);
Image picture_of(const ColoredShape& shape, const SheetView& view);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "mscomp/model/components.h"
#include "mscomp/model/synthesis.h"
#include "mscomp/run/component_meshes.h"

namespace mscomp {

/// The reference and some shapes. Here and below `longer_side` is that of one picture, in pixels.
Image shapes_sheet(const std::string& title, const std::string& heading,
                   const TriangleMesh& reference, const std::vector<ColoredShape>& shapes,
                   const std::vector<std::string>& names, int longer_side);

/// Components x weights, as many in every row, at least one row; each is coloured by how far its
/// vertices move, full where they move farthest. Borrows everything.
class SynthesisSheet {
  public:
    SynthesisSheet(const TriangleMesh& reference, const ComponentMeshes& meshes,
                   const Synthesis& synthesis)
        : reference_(reference), meshes_(meshes), synthesis_(synthesis) {}

    void add_row(const Component& component, const std::vector<double>& weights);
    Image draw(const std::string& title, int longer_side) const;

  private:
    const TriangleMesh& reference_;
    const ComponentMeshes& meshes_;
    const Synthesis& synthesis_;
    std::vector<ColoredShape> all_;
    std::vector<std::string> labels_, headings_;
};

}  // namespace mscomp

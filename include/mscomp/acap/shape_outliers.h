// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// What `acapfeat check` says of a whole shape, for who works through a set anyway: another size,
/// another order of the vertices, a stretch far beyond all others.
class ShapeOutliers {
  public:
    /// `surface` is the reference on its W places.
    ShapeOutliers(const TriangleMesh& surface, int shape_count);
    ~ShapeOutliers();

    /// Shape `index` with its positions (W) and features (W,9). From any thread, each shape once;
    /// the same warnings in any order.
    void look_at(int index, const std::vector<Point>& positions, std::span<const float> features);
    /// One sentence for each kind, with the first shape by name (N).
    std::vector<std::string> warnings(const std::vector<std::string>& names) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mscomp/eval/measures.h"
#include "mscomp/eval/sted.h"

namespace mscomp {

/// How far one result is from its truth, after rigid alignment.
struct ShapeErrors {
    std::string name;
    double rms_error = 0;             // E_rms of this shape alone
    double mean_vertex_distance = 0;  // in the unit of the input
    double max_vertex_distance = 0;
    int worst_vertex = 0;  // where the largest distance is; the lowest index
    std::optional<double> relative_squared_error;  // [A] eq. 8, where the caller knows features
};

/// How far all results are from their truths.
struct SetErrors {
    int shape_count = 0;
    double rms_error = 0;             // pooled (RmsError); this and what follows NaN without shapes
    double mean_vertex_distance = 0;  // over all vertices of all shapes, unit of the input
    double max_vertex_distance = 0;
    StedError sted;
    // Over the shapes that have one; none if none has.
    std::optional<double> relative_squared_error_mean, relative_squared_error_max;
};

/// All measures of method §6 that compare results with truths. Shapes are added one by one (frames
/// of a sequence in their order) and not kept: a row of numbers for each, and the last steps of
/// STED. A number that is not finite anywhere in a result makes the measures NaN, never small.
class ShapeMeasures {
  public:
    /// Throws as RmsError and Sted.
    ShapeMeasures(const TriangleMesh& reference, ShapeOrder order, const StedOptions& options = {});
    /// The row of this shape. Truth and result may lie anywhere, but for a sequence, where `truth`
    /// has to be where the frame really is (Sted::add), or `truth_in_place` says where that is.
    /// Throws MeshError if a number of vertices differs from the reference's.
    const ShapeErrors& add(std::string name, const std::vector<Point>& truth,
                           const std::vector<Point>& result,
                           std::optional<double> relative_squared_error = std::nullopt,
                           const std::vector<Point>& truth_in_place = {});
    /// In the order in which they were added.
    const std::vector<ShapeErrors>& shapes() const { return shapes_; }
    SetErrors total() const;

  private:
    RmsError rms_error_;
    Sted sted_;
    std::vector<ShapeErrors> shapes_;
};

/// Indices of the `count` shapes (or all, if there are fewer) with the largest E_rms, the worst
/// first; NaN is worse than any number, the earlier of equals comes first.
std::vector<int> worst_shapes(std::span<const ShapeErrors> shapes, int count);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/base/mesh_data.h"
#include "vertex_order.h"

namespace mscomp {

/// What the edge lengths of one shape say about the order of its vertices.
struct EdgeStretch {
    double median_ratio = 1;  // of deformed to reference length
    double size_ratio = 1;    // of the RMS distance from the centroid; blind to the order
    bool permuted = false;    // vertices, or blocks of them, sit where others belong
    int first_permuted = -1;  // lowest vertex that is clearly out of place; 0 where all are shifted
    std::vector<int> stray;   // vertices far from all their neighbours, unless permuted
    std::vector<int> shrunk;  // vertices whose edges are all far shorter than in the reference

    /// Whether all of it is so much larger or smaller that it looks like another unit.
    bool is_other_unit() const {
        constexpr double kOtherUnit = 2.0;
        return (size_ratio > kOtherUnit && median_ratio > kOtherUnit) ||
               (size_ratio * kOtherUnit < 1 && median_ratio * kOtherUnit < 1);
    }
};

/// Compares edge lengths with those of a reference, and looks at the order of the vertices.
class EdgeStretchTest {
  public:
    EdgeStretchTest(const std::vector<Point>& reference, const OneRings& rings);

    EdgeStretch compare(const std::vector<Point>& shape) const;

    std::size_t edge_count() const { return all_edges_; }

  private:
    struct Edge {
        int from, to;
        double log_length;
    };

    std::vector<double> log_ratios(const std::vector<Point>& shape, std::size_t shift) const;
    bool fits_better_shifted(const std::vector<Point>& shape,
                             const std::vector<double>& ratios) const;

    std::size_t vertex_count_;
    std::size_t all_edges_;
    std::vector<Edge> edges_;  // of positive length in the reference
    VertexOrderTest order_;
    double radius_;
};

/// Root mean square distance from the centroid.
double rms_radius(const std::vector<Point>& points);
Point centroid_of(const std::vector<Point>& points);

}  // namespace mscomp

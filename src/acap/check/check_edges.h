// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// What the edge lengths of one shape say about the order of its vertices.
struct EdgeStretch {
    double median_ratio = 1;  // of deformed to reference length
    double size_ratio = 1;    // of the RMS distance from the centroid; blind to the order
    bool permuted = false;    // vertices, or blocks of them, sit where others belong
    int first_permuted = -1;  // lowest vertex that is clearly out of place
    std::vector<int> stray;   // vertices far from all their neighbours, unless permuted
    std::vector<int> shrunk;  // vertices whose edges are all far shorter than in the reference
};

/// Compares edge lengths with those of a reference. Deformed shapes keep the lengths of nearly all
/// edges near one common ratio, however far they bend; a wrong vertex order does not.
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
    double median_length(const std::vector<double>& ratios) const;
    int first_out_of_place(const std::vector<double>& ratios, double log_size_ratio) const;

    std::size_t vertex_count_;
    std::size_t all_edges_;
    std::vector<Edge> edges_;  // of positive length in the reference
    double radius_;
};

/// Root mean square distance from the centroid.
double rms_radius(const std::vector<Point>& points);
Point centroid_of(const std::vector<Point>& points);

}  // namespace mscomp

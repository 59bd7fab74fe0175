// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "acap/deformation_gradient.h"
#include "check_edges.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/base/vertex_places.h"
#include "pinched_rings.h"
#include "stretch_histogram.h"

namespace mscomp {

constexpr std::size_t kInvariants = 8;

/// One shape in numbers.
struct FrameFacts {
    std::array<std::uint64_t, 2> hash{};          // of the positions, bit by bit
    std::array<double, kInvariants> invariant{};  // blind to rigid motion; see frame_invariants
    EdgeStretch edges;
    double offset = 0;           // of the centroid from the reference's, in the larger radius
    double origin_distance = 0;  // of the farthest vertex, in sizes: distance_from_origin
    double bend_agreement = 1;   // correlation of the bends across edges; -1 for a mirror image
    bool finite = true;          // every deformation gradient is
    Occurrences zero_area_faces, folded_rings, mirrored;
    double largest_stretch = 0;  // |S - I|, largest entry
    int largest_stretch_vertex = -1;
    bool opens_a_pinch = false;  // there: the reference is pinched, and the shape is not
    double sharpest_turn = 0;    // radians between the rotations of two neighbours
    int sharpest_turn_vertex = -1;
};

/// Measures shapes against a reference of the same connectivity. Vertices that no face uses have no
/// say in anything but the hash.
class FrameMeter {
  public:
    /// Throws MeshError if the reference has no face with an area.
    FrameMeter(const TriangleMesh& reference, VertexPlaces used);
    FrameMeter(const FrameMeter&) = delete;
    FrameMeter& operator=(const FrameMeter&) = delete;

    /// Facts about `shape` (V positions); adds its |S - I| to `histogram`.
    FrameFacts measure(const std::vector<Point>& shape, StretchHistogram& histogram) const;

    /// Of the vertices that faces use.
    const DeformationGradients& gradients() const { return gradients_; }
    /// The number in the files of such a vertex.
    int vertex(int used) const { return used_.vertex(used); }
    const EdgeStretchTest& edges() const { return edges_; }
    double radius() const { return radius_; }

  private:
    void measure_gradients(const std::vector<Point>& shape, FrameFacts& facts,
                           StretchHistogram& histogram) const;
    void measure_turns(const std::vector<Eigen::Matrix3d>& rotations, FrameFacts& facts) const;
    std::vector<double> bends(const std::vector<Point>& shape) const;

    /// An edge between two faces that pass it in opposite directions.
    struct Hinge {
        int from, to;
        int left, right;
    };

    FrameFacts measure_used(const std::vector<Point>& shape, StretchHistogram& histogram) const;
    void number_as_files(FrameFacts& facts) const;

    VertexPlaces used_;
    TriangleMesh reference_;  // of the vertices that faces use, as all below
    DeformationGradients gradients_;
    EdgeStretchTest edges_;
    std::vector<Hinge> hinges_;
    std::vector<double> reference_bends_;
    Point center_;
    double radius_;
    PinchedRings pinch_;
};

}  // namespace mscomp

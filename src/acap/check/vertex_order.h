// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Tells shapes whose vertices sit where others belong from shapes that are only strongly deformed.
///
/// What counts is a vertex beside its own ring: how far it is from the mean of its neighbours, in
/// root mean squares of their distances from there. Nothing that deforms a ring as a whole,
/// however far it stretches, takes a vertex out of it; a vertex that was put elsewhere, or whose
/// neighbours were, is out of it.
class VertexOrderTest {
  public:
    VertexOrderTest(const std::vector<Point>& reference, const OneRings& rings);

    /// The lowest vertex out of place in `shape` (V), -1 if none is.
    int first_out_of_place(const std::vector<Point>& shape) const;

  private:
    /// The mean of a vertex's neighbours and how they spread about it.
    struct Ring {
        Point center{};
        double spread = 0;
        double offset = 0;  // of the vertex from the centre, in spreads; 0 with fewer than three
    };
    std::vector<Ring> rings_of(const std::vector<Point>& shape) const;
    std::vector<char> out_of_ring(const std::vector<Ring>& rings, double least) const;
    double usual_ratio(const std::vector<Ring>& rings, double size_ratio) const;
    int first_of_many(const std::vector<Ring>& rings) const;
    int first_of_crowd(const std::vector<Ring>& rings, double size_ratio) const;
    int first_exchanged(const std::vector<Ring>& rings, const std::vector<Point>& shape) const;
    int first_torn(const std::vector<Point>& shape) const;

    OneRings rings_;
    std::vector<Point> reference_;
    std::vector<Ring> of_reference_;
};

}  // namespace mscomp

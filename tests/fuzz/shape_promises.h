// SPDX-License-Identifier: MIT
// What holds for every set of shapes that a reader gives.
#pragma once

#include <cmath>

#include "fuzz/promises.h"
#include "mscomp/acap/mesh/shape_source.h"

namespace mscomp::fuzz {

/// Counts agree, numbers are finite, faces refer to vertices. Throws what reading a shape throws.
inline void check_sound(const ShapeSource& shapes) {
    require(shapes.shape_count() > 0 && shapes.vertex_count() > 0 && !shapes.faces().empty(),
            "there are shapes, vertices and faces");
    for (const Face& face : shapes.faces()) {
        for (const int corner : face) {
            require(corner >= 0 && corner < shapes.vertex_count(), "faces refer to vertices");
        }
    }
    for (int i = 0; i < shapes.shape_count(); ++i) {
        const std::vector<Point> points = shapes.shape(i);
        require(static_cast<int>(points.size()) == shapes.vertex_count(), "counts agree");
        for (const Point& point : points) {
            for (const double x : point) require(std::isfinite(x), "coordinates are finite");
        }
    }
}

/// `read` is what was written, bit for bit.
inline void check_same(const ShapeSource& read, const ShapeSource& written) {
    require(read.names() == written.names() && read.faces() == written.faces(),
            "names and faces survive");
    for (int i = 0; i < written.shape_count(); ++i) {
        require(same_bits(read.shape(i), written.shape(i)), "coordinates survive, bit for bit");
    }
}

}  // namespace mscomp::fuzz

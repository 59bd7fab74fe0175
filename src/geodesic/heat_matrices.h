// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/SparseCore>
#include <span>
#include <vector>

#include "mscomp/geodesic/intrinsic_triangles.h"

namespace mscomp {

/// One undirected edge of the surface; several between the same two vertices count as one.
struct IntrinsicEdge {
    int i = 0, j = 0;   // i <= j
    double weight = 0;  // cotangent weights in all
    double length = 0;  // of the shortest, in mean edge lengths
};
std::vector<IntrinsicEdge> intrinsic_edges(const IntrinsicTriangles& surface);

/// (C) for every component a length that about bounds its distances: that of the longest of the
/// shortest paths along edges from the vertex that is farthest from the component's lowest one.
std::vector<double> component_extents(const IntrinsicTriangles& surface,
                                      std::span<const IntrinsicEdge> edges);

/// Lower triangle of M + t L with `time` (C) by component; rows of `lonely` vertices are those of
/// the identity.
Eigen::SparseMatrix<double> heat_matrix(const IntrinsicTriangles& surface,
                                        std::span<const IntrinsicEdge> edges,
                                        std::span<const double> time,
                                        const std::vector<bool>& lonely);

/// Lower triangle of L; rows and columns of `anchored` vertices are those of the identity.
Eigen::SparseMatrix<double> poisson_matrix(std::span<const IntrinsicEdge> edges,
                                           const std::vector<bool>& anchored);

}  // namespace mscomp

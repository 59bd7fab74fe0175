// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "deformation_gradient.h"
#include "mscomp/acap/alignment.h"
#include "occurrences.h"

namespace mscomp {

/// What one shape brings before its turns are chosen.
struct ExtractedShape {
    RigidMotion motion;                                   // of the alignment
    std::vector<float> vertices;                          // (V,3) aligned
    std::vector<float> features;                          // (V,9) principal logarithms and S
    Occurrences zero_area_faces, folded_rings, mirrored;  // the last by vertex
};

/// Aligned to `reference` (V) by the best rigid motion if `align`, then T = R S at every vertex.
ExtractedShape extract_shape(const DeformationGradients& gradients,
                             const std::vector<Point>& reference, const std::vector<Point>& shape,
                             bool align);

/// The r of a row of features (V,9), and back.
std::vector<Eigen::Vector3d> rotation_vectors_of(std::span<const float> row);
void store_rotation_vectors(const std::vector<Eigen::Vector3d>& rotation_vectors,
                            std::span<float> row);

}  // namespace mscomp

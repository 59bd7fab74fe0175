// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "deformation_gradient.h"
#include "occurrences.h"

namespace mscomp {

/// What one shape brings before its turns are chosen.
struct ExtractedShape {
    std::vector<float> features;                          // (V,9) principal logarithms and S
    Occurrences zero_area_faces, folded_rings, mirrored;  // the last by vertex
};

/// T = R S at every vertex of `shape` (V), which is aligned.
ExtractedShape extract_shape(const DeformationGradients& gradients,
                             const std::vector<Point>& shape);

/// The r of a row of features (V,9), and back.
std::vector<Eigen::Vector3d> rotation_vectors_of(std::span<const float> row);
void store_rotation_vectors(const std::vector<Eigen::Vector3d>& rotation_vectors,
                            std::span<float> row);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "deformation_gradient.h"
#include "mscomp/acap/placed_features.h"
#include "occurrences.h"

namespace mscomp {

/// What is odd about one shape; by face and by place.
struct ShapeOddities {
    Occurrences zero_area_faces, folded_rings, mirrored;
    bool far_from_origin = false;  // where float32 has to hold it
};

/// Appends to set.warnings what is odd about the reference, whose `gradients` are those of its
/// places, and about the shapes (N). Vertices and faces are told as the files have them, from 1;
/// `face_numbers` as ShapeSource::face_numbers.
void warn_of_oddities(const DeformationGradients& gradients,
                      const std::vector<ShapeOddities>& shapes,
                      const std::vector<int>& face_numbers, PlacedFeatures& set);

/// Says that positions are kept relative to `origin`, where the reference lay.
void warn_of_moved_origin(const Point& origin, PlacedFeatures& set);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mscomp/acap/mirror.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/model/components.h"
#include "mscomp/render/viewpoint.h"

namespace mscomp {

/// Where a component acts beside the mirror plane of the reference.
struct ComponentSide {
    /// Of its square, on the side that the normal of the plane points to; none for a component that
    /// does nothing.
    std::optional<double> part;
    int partner = -1;  // the component that it is the mirror image of; -1: none
};

/// Of components whose differences are features (V,9) or positions (V,3), counted by area. Partners
/// are each other's most alike: the mirror image of one end of one has a cosine of at least 0.7
/// with an end of the other, more than with any third. None is its own.
std::vector<ComponentSide> component_sides(std::span<const Component> components,
                                           const TriangleMesh& reference, const Mirror& mirror);

/// "left", "right" or "middle" where at least four fifths of a component, or less, act on one side,
/// as the shape itself would say it: left is up x front. "" where the plane does not part left from
/// right, so that the front is no more than guessed, and for a component that does nothing.
std::string side_name(const ComponentSide& side, const Mirror& mirror, const Stance& stance);

/// "turns", "stretches" or "both" ("" for nothing at all) by whether four fifths of the square of a
/// difference of features, counted by area, are in rotations or in stretch.
std::string way_of_acting(std::span<const float> difference, std::span<const float> area_roots);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Channels of an ACAP feature: r_x r_y r_z S11 S12 S13 S22 S23 S33 (method: layout).
inline constexpr int kFeatureDim = 9;
inline constexpr int kRotationDim = 3;
/// The feature of the undeformed reference: r = 0, S = I.
inline constexpr std::array<float, kFeatureDim> kReferenceFeature{0, 0, 0, 1, 0, 0, 1, 0, 1};

/// The ACAP features of N shapes of one connectivity and what is needed to go back to vertices.
struct FeatureSet {
    std::vector<std::string> names;  // (N) file stems
    std::vector<float> features;     // (N,V,9)
    std::vector<float> vertices;     // (N,V,3) aligned input, unit of the input
    TriangleMesh reference;          // V positions, F faces
    std::vector<std::array<double, 9>>
        rotation;  // (N) row-major; aligned = rotation * input + translation
    std::vector<std::array<double, 3>> translation;  // (N)
    std::string weights = "cotangent";               // cotangent | authors | uniform
    std::vector<double> consistency_energy;  // (N), may be empty for files of other programs
    std::vector<double> consistency_gap;     // (N) energy minus a proved lower bound, likewise
    std::vector<double> largest_jump;        // (N) radians, likewise
    std::vector<std::string> warnings;       // what extraction had to say

    int shape_count() const { return static_cast<int>(names.size()); }
    int vertex_count() const { return reference.vertex_count(); }
    /// (V,9) of one shape.
    std::span<const float> shape(int index) const {
        const auto size = static_cast<std::size_t>(vertex_count()) * kFeatureDim;
        return {features.data() + static_cast<std::size_t>(index) * size, size};
    }
};

}  // namespace mscomp

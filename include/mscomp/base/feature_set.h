// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/index.h"
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
    // What the choice of turns came to; (N) each, or empty for files of other programs.
    std::vector<double> principal_energy;    // of the principal logarithms
    std::vector<double> propagation_energy;  // of propagation from the root
    std::vector<double> relaxation_energy;   // of the rounded relaxation, NaN if not needed
    std::vector<double> consistency_energy;  // of the result, never above these
    std::vector<double> consistency_gap;     // energy minus a proved lower bound
    std::vector<double> largest_jump;        // across an edge, radians
    std::vector<double> large_jumps;         // edges with more than π
    std::vector<double> inherent_jumps;      // of these: whatever the turns of the two ends are
    std::vector<double> removable_jumps;     // of these: not shown to be the price of the energy
    std::vector<std::string> warnings;       // what extraction had to say

    int shape_count() const { return static_cast<int>(names.size()); }
    int vertex_count() const { return reference.vertex_count(); }
    /// Whether the turns of shape `index` are proved to have the least energy of all, up to
    /// rounding; false where nothing is known.
    bool is_proved(int index) const {
        const auto n = at(index);
        if (n >= consistency_gap.size() || n >= consistency_energy.size()) return false;
        return consistency_gap[n] <= 1e-9 * (1 + consistency_energy[n]);
    }
    /// (V,9) of one shape.
    std::span<const float> shape(int index) const {
        const auto size = at(vertex_count()) * kFeatureDim;
        return {features.data() + at(index) * size, size};
    }
};

}  // namespace mscomp

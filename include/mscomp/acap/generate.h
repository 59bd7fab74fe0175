// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mscomp/acap/mesh/mesh_sequence.h"

namespace mscomp {

/// A sequence made of K known components, so that extracted ones can be measured against the truth.
struct GeneratedSequence {
    MeshSequence sequence;                     // N frames; frame 0 is the undeformed reference
    std::vector<std::string> component_names;  // (K)
    std::vector<int> scales;                   // (K) 0 = coarse, 1 = fine
    std::vector<float> weights;                // (N,K) in [-1, 1]; 0 in frame 0
    /// (K,V) in [0, 1]: how much of component k reaches vertex i. For a joint or a twist the share
    /// of its rotation that the vertex takes part in (0 before the joint, 1 beyond it), for a bulge
    /// or a ripple the height of its envelope relative to the highest. Exactly 0 outside.
    std::vector<float> supports;

    int component_count() const { return static_cast<int>(component_names.size()); }
};

/// A limb (closed manifold of even triangles, at least `vertices` of them, about 12 units long):
/// upper arm, elbow, forearm, wrist, hand. Coarse: the shoulder lifts and swings, the elbow bends
/// to 120 degrees, the forearm twists linearly along its length to 270 degrees, the wrist bends.
/// Fine and independent of it: four muscles, a knuckle and two ripples. The weights are smooth in
/// time, each of its own frequency, so that no two are correlated over the frames after the first;
/// `seed` draws who moves how fast and when. Throws UsageError if frames < 2 or vertices < 100.
GeneratedSequence generate_arm(int frames = 60, std::uint64_t seed = 0, int vertices = 3000);

/// Writes frame_0000.obj ... into `folder`, and beside them truth.json (names, scales, weights) and
/// truth_supports.safetensors ("supports", (K,V) f32). Throws IoError.
void write_generated(const GeneratedSequence& generated, const std::string& folder);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mscomp/acap/mesh/mesh_sequence.h"

namespace mscomp {

/// The exact rotations of a twisted bar.
struct RotationTruth {
    /// (N,V,3) accumulated angle times axis of the rotation that carries the vertex's ring: exact
    /// for every vertex and frame, many turns included, noise aside.
    std::vector<float> rotation;
    /// (N,V,9) ACAP features (cotangent weights, no alignment) in closed form where `exact` is 1,
    /// the reference's elsewhere; r is the logarithm that is nearest to `rotation`. Noise aside;
    /// empty when the axis tilts.
    std::vector<float> features;
    /// (V) 1 where the closed form holds: all vertices but those of the two end rings.
    std::vector<std::uint8_t> exact;
};

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
    RotationTruth rotation_truth;  // of `twist`, empty for all others

    int component_count() const { return static_cast<int>(component_names.size()); }
};

/// A limb (closed manifold of even triangles, at least `vertices` of them, about 12 units long):
/// upper arm, elbow, forearm, wrist, hand. Coarse: the shoulder lifts and swings, the elbow bends
/// to 120 degrees, the forearm twists linearly along its length to 270 degrees, the wrist bends.
/// Fine and independent of it: four muscles, a knuckle and two ripples. The weights are smooth in
/// time, each of its own frequency, so that no two are correlated over the frames after the first;
/// `seed` draws who moves how fast and when. Throws UsageError unless frames are 2 to 10^6 and
/// vertices 100 to 2 * 10^7.
GeneratedSequence generate_arm(int frames = 60, std::uint64_t seed = 0, int vertices = 3000);

/// A sheet of 14 x 9 units with a boundary, exactly flat in frame 0 (z = 0). Coarse: both sides
/// swing, two folds a quarter of a wave apart travel through the middle, the corners curl up; all
/// by bending without stretching. Fine: six patches of wrinkles along the normal, which stretch by
/// a few percent. Weights and errors as for the arm.
GeneratedSequence generate_cloth(int frames = 60, std::uint64_t seed = 0, int vertices = 3000);

/// A head (closed manifold, about 2 units high, +y up, looking to +z, no neck) whose triangles are
/// smaller in front. Coarse: the jaw opens and slides, the forehead rises, cheeks and lips move;
/// fine: one side's or one part's expressions. All supports overlap others. The jaw turns, all else
/// moves along a fixed direction per vertex. Weights and errors as for the arm.
GeneratedSequence generate_face(int frames = 60, std::uint64_t seed = 0, int vertices = 3000);

struct TwistOptions {
    double turns = 3;  // of the far end in the last frame, negative: the other way round
    double tilt = 0;  // degrees by which the axis of rotation leans over, from one end to the other
    double noise = 0;  // standard deviation of the positions, relative to the mean edge length
    /// Radius relative to the spacing of the rings; 1.52 makes the triangles equilateral. The
    /// surface shears by this much per ring, so that near a full turn the rotation is a small one
    /// about the radius, and going on through it is the least energy only if the bar is thin and
    /// no ring lies on a full turn: docs/generated-data.md.
    double thickness = 0.05;
};

/// A round bar (closed manifold of equal triangles, rings of 8 vertices, length 10) twisted by
/// several turns: in frame n the ring at height s is carried by exp(phi a), phi = 2 pi turns
/// s/10 n/(N-1), with a the axis of the bar where tilt = 0. Otherwise a leans over linearly along
/// the bar, which lies oblique and bends into a coil; its middle line keeps its length. `seed`
/// draws the noise, which spares frame 0. One component, `twist`. Throws UsageError if frames or
/// vertices are as the arm refuses them, an option is out of range, or two rings are half a turn or
/// more apart.
GeneratedSequence generate_twist(int frames = 60, std::uint64_t seed = 0, int vertices = 400,
                                 const TwistOptions& options = {});

/// Writes frame_0000.obj ... into `folder`, and beside them truth.json (names, scales, weights) and
/// truth_supports.safetensors ("supports", (K,V) f32); where there is a rotation truth, also
/// truth_rotation.safetensors ("rotation" (N,V,3) f32, "exact" (V) u8, and where known "features"
/// (N,V,9) f32). Throws IoError.
void write_generated(const GeneratedSequence& generated, const std::string& folder);

}  // namespace mscomp

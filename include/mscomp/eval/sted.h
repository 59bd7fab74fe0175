// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Whether shapes follow each other in time.
enum class ShapeOrder { set, sequence };

/// Parameters of STED; the topological distance d is 1 (the edges at a vertex).
struct StedOptions {
    int window = 1;     // w: steps on either side of one whose mean length normalises it
    double dt = 0.002;  // length of one frame in the unit ball, > 0
    double temporal_weight = 0.127;  // c
};

/// STED and its two parts.
struct StedError {
    double spatial = 0;              // NaN before the first shape
    std::optional<double> temporal;  // none for a set, or with fewer than two frames
    std::optional<double> value;     // sqrt(spatial^2 + c^2 temporal^2), none without temporal
};

/// Spatio-temporal edge difference (Váša & Skala 2011; method §6), a measure of how different two
/// moving meshes look: it sees uneven stretching and jitter, not where things are. Frames are added
/// one by one in their order; what is kept are the last 2w+1 steps.
///
/// Before: every result is moved to its truth by the best rigid motion, and positions are scaled by
/// unit_ball_scale(reference). l and l' are lengths in truth and result.
///
/// Spatial part: for edge e in frame f, u(e,f) = |l'(e,f) - l(e,f)| / l(e,f); at vertex v, over its
/// edges e with weights l(e,f), the weighted standard deviation
///     s(v,f) = sqrt( Σ_e l (u - m)^2 / Σ_e l ),   m = Σ_e l u / Σ_e l;
/// spatial = mean of s over all vertices and frames. Vertices without edges are left out, edges
/// that have no length in the truth weigh nothing.
///
/// Temporal part: vertex v moves from frame f to f+1 along an edge of length
///     t(v,f) = sqrt( |p(v,f+1) - p(v,f)|^2 + dt^2 );
/// with M(v,f) the mean of t(v,g) over the steps g of the sequence with |g - f| <= w,
/// temporal = mean over all vertices and steps of |t'(v,f) - t(v,f)| / M(v,f).
///
/// The window reaches w steps to either side and is cut at the ends of the sequence.
class Sted {
  public:
    /// Throws MeshError if there are no vertices, UsageError for options out of range.
    Sted(const TriangleMesh& reference, ShapeOrder order, const StedOptions& options = {});
    /// The next frame, with the truth where it really is: the temporal part looks at its way, which
    /// is lost in truths that were aligned one by one. The result may lie anywhere. Throws
    /// MeshError if a number of vertices differs from the reference's.
    void add(const std::vector<Point>& truth, const std::vector<Point>& result);
    StedError value() const;

  private:
    /// Steps from one frame to the next, (V) each.
    struct Step {
        std::vector<double> length;      // t
        std::vector<double> difference;  // |t' - t|
    };
    void add_step(const std::vector<Point>& truth, const std::vector<Point>& aligned);
    double change_in(int step) const;

    OneRings rings_;
    double scale_;
    ShapeOrder order_;
    StedOptions options_;
    double deviations_ = 0;       // Σ s(v,f)
    double deviation_count_ = 0;  // of how many
    std::vector<Point> truth_before_, aligned_before_;
    std::deque<Step> recent_;
    int step_count_ = 0, first_recent_ = 0;
    int done_ = 0;        // steps whose window is complete
    double changes_ = 0;  // Σ |t' - t| / M over these
};

}  // namespace mscomp

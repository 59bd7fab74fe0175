// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "consistency_graph.h"

namespace mscomp {

/// Energies Σ_edges |r_i - r_j|² of one shape.
struct ConsistencySummary {
    double principal_energy = 0;    // all turns 0
    double propagation_energy = 0;  // each vertex nearest to its predecessor from the root
    // The relaxed solution, rounded; NaN where the result was proved without it.
    double relaxation_energy = std::numeric_limits<double>::quiet_NaN();
    double energy = 0;  // the result, never above the three
    // No choice of turns about the axes in use has less; equals energy where proved.
    double lower_bound = 0;
    double largest_jump = 0;  // max |r_i - r_j| of the result, radians
    int large_jumps = 0;      // edges above π, by more than rounding
    int inherent_jumps = 0;   // of these: above π whatever the turns of the two ends are
    // Of these: not shown to cost energy if brought to π or below. 0 proves that no move of any set
    // of vertices removes a large jump without raising the energy.
    int removable_jumps = 0;
};

/// Replaces principal logarithms r = ω θ (V) by ω (θ + 2π t), t integer, so that
/// Σ_edges |r_i - r_j|² is small (method §1, consistency); the roots keep their principal one.
/// Where θ is below 1e-4 a turn goes around the axis that the neighbours have: exp(r) is then
/// off by at most 1e-4.
ConsistencySummary make_consistent(const ConsistencyGraph& graph,
                                   std::vector<Eigen::Vector3d>& rotation_vectors);

/// A further start for a shape of a sequence: the turns that bring each vertex nearest to `start`
/// (V), the vectors of the shape before or after it, polished. `rotation_vectors` (V) and `summary`
/// are what `make_consistent` gave, perhaps rounded to float. If that lowers the energy, both are
/// replaced, the vertices that keep their turn bit for bit; roots never move.
/// \return whether the energy fell
bool improve_consistency(const ConsistencyGraph& graph, const std::vector<Eigen::Vector3d>& start,
                         std::vector<Eigen::Vector3d>& rotation_vectors,
                         ConsistencySummary& summary);

}  // namespace mscomp

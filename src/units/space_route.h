// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "multiscale/metric_rows.h"
#include "units/unit_codes.h"

namespace mscomp {

/// Relative rotations at some edges that lie evenly over a mesh, and which of these read-outs begin
/// at.
struct EdgeSample {
    Eigen::MatrixXd values;    // (3n,N) of all shapes
    std::vector<int> seeds;    // places in the sample, evenly over the edges that move
    double edges_of_each = 1;  // how many edges of the mesh one of the sample stands for
};

/// Of relative rotations (E,3) of N shapes along edges with these middles. Read-outs begin at edges
/// that turn by at least 5 % of what the most turning one does.
EdgeSample edge_sample(const MetricRows& turns, const std::vector<Point>& middles);

/// Shapes `which` alone.
EdgeSample part_of(const EdgeSample& sample, const std::vector<int>& which);

/// Which of M candidates are needed, in the order in which they are taken: those whose codes (N,M)
/// are left by those taken before, the largest first; then those that act where these leave
/// something of their changes (r,M), of unit length, the strongest there first. No joint is taken
/// twice: candidates whose codes correlate by 0.9 and that share half of their place are one that
/// bends a little otherwise with another. `all`: the squares of all shapes.
std::vector<int> needed_turns(const Eigen::MatrixXd& codes, const Eigen::MatrixXd& changes,
                              double all);

/// Units that are sparse in relative rotations, and how to read them in any shape.
struct TurningUnits {
    UnitCodes units;           // codes (N,K), votes: read-outs that agree
    Eigen::MatrixXd readouts;  // (N,K): the code of a shape x is Σ_n readouts(n,k) x·x_n
};

/// Joints, from inner products (N,N) of the relative rotations of all pairs of shapes and a sample
/// of these (method §10, space route): for each edge that the sample says, and each of the three
/// directions in which it turns, the change d = V c of relative rotations in the space that shapes
/// span which is 1 there and as quiet as possible at all other edges; its code is x·d. Those whose
/// codes correlate by 0.95 are one, the quietest stands for them, three have to agree. Of these
/// are taken, the strongest of what is left first, those whose codes the others leave, and then
/// those that the others leave in space. `noise`: the part of the length of all shapes, about, that
/// is no movement.
TurningUnits space_route(const Eigen::MatrixXd& gram, const EdgeSample& sample, double noise);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "surface_tree.h"

namespace mscomp {

/// The plane n·x = offset, and the reflection about it.
struct MirrorPlane {
    Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  // of length 1
    double offset = 0;

    Eigen::Matrix3d matrix() const {
        return Eigen::Matrix3d::Identity() - 2 * normal * normal.transpose();
    }
    Eigen::Vector3d reflected(const Eigen::Vector3d& point) const {
        return point - 2 * (normal.dot(point) - offset) * normal;
    }
};

/// Planes to start from, of a surface in the unit ball: through its centroid, across its principal
/// axes, that of the longest extent first; where two of these are nearly as long, which makes them
/// any ones between, also across directions between them.
std::vector<MirrorPlane> start_planes(const TriangleMesh& mesh);

struct MirrorFit {
    MirrorPlane plane;
    double cost = 0;  // mean of ρ(distance)
};

/// The plane near `start` about which the reflected `points`, of the unit ball, come nearest to
/// the surface: a local minimum of the mean of ρ(distance), ρ Huber's function, which is a square
/// below 0.02 only, so that an arm held differently does not turn the plane. Levenberg-Marquardt on
/// the three parameters of a plane, until a step lowers the cost by no more than `least` of it; the
/// same bits for any number of threads.
MirrorFit fitted_mirror(const SurfaceTree& surface, std::span<const Eigen::Vector3d> points,
                        const MirrorPlane& start, double least);

}  // namespace mscomp

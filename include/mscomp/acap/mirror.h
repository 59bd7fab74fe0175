// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Where on a mesh a point of its surface lies: the corners of a face, and what each of them
/// counts. The weights are not negative and sum to 1; those below 10⁻⁶ are 0.
struct SurfaceLocation {
    std::array<int, 3> corners{};
    std::array<float, 3> weights{1, 0, 0};
};

/// The reflection x → M x + t about a plane that a mesh is symmetric to, M = I - 2 n nᵀ, in the
/// unit of the mesh.
struct Mirror {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();  // M, symmetric, M M = I, det M = -1
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();
    /// Mean distance of the reflected vertices from the surface, beside the radius of the mesh.
    double distance = 0;
    /// (V) The point of the surface that the reflected vertex is nearest to; as lips touch, and
    /// both sides of cloth, a point where the surface faces as the reflected one does is preferred
    /// if it is at most a hundredth of the radius farther. A vertex without a face is its own
    /// partner.
    std::vector<SurfaceLocation> partners;

    int vertex_count() const { return static_cast<int>(partners.size()); }
    Point reflected(const Point& point) const;
};

/// The reflection that brings `reference` onto itself, none if the mean distance that it leaves is
/// more than `most` of the radius (the farthest vertex from their centroid; vertices without a face
/// count nowhere), or if there is no surface or a number that is not finite. Found by registration
/// from planes across the principal axes; of several that are as good the one across the longest
/// axis. A mesh in its own plane may be its own mirror image. About linear in V + F; the same bits
/// for any number of threads. Faces have to refer to vertices.
std::optional<Mirror> mirror_of(const TriangleMesh& reference, double most = 0.02);

}  // namespace mscomp

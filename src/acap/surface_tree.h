// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <vector>

#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// A point of a surface: the face it lies in and the weights of the corners of that, which sum
/// to 1.
struct SurfacePoint {
    int face = -1;  // -1: there is none
    Eigen::Vector3d weights = Eigen::Vector3d::Zero();
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    double square = std::numeric_limits<double>::infinity();  // squared distance of what was asked
};

/// Finds the points of a surface that are nearest to given ones, by boxes around boxes around a few
/// faces: built in O(F log F). Faces without area are no part of it.
class SurfaceTree {
  public:
    explicit SurfaceTree(const TriangleMesh& mesh);

    bool is_empty() const { return nodes_.empty(); }
    SurfacePoint nearest(const Eigen::Vector3d& point) const;
    /// Of the faces whose normal is less than a right angle from `direction`, if less than `within`
    /// away.
    SurfacePoint nearest_facing(const Eigen::Vector3d& point, const Eigen::Vector3d& direction,
                                double within) const;
    /// Unit normal of a face of the mesh that has area, as found in a SurfacePoint.
    Eigen::Vector3d normal(const SurfacePoint& point) const { return normals_[slot(point)]; }

  private:
    struct Node {
        Eigen::Vector3d low, high;
        int first = 0, count = 0;  // of the faces in a leaf; none in any other node
        int right = 0;             // the left child is the next node
        double square_distance(const Eigen::Vector3d& point) const;
    };
    struct Corners {
        Eigen::Vector3d a, b, c;
        int face = 0;
    };

    std::size_t slot(const SurfacePoint& point) const;
    int build(std::size_t first, std::size_t end);
    template <class IsWanted>
    SurfacePoint search(const Eigen::Vector3d& point, double within, IsWanted&& is_wanted) const;

    std::vector<Corners> faces_;            // leaf by leaf
    std::vector<Eigen::Vector3d> normals_;  // beside them
    std::vector<std::size_t> slots_;        // (F) where each lies
    std::vector<Node> nodes_;
};

}  // namespace mscomp

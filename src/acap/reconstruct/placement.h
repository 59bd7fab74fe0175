// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "mscomp/base/mesh_data.h"
#include "piece_links.h"

namespace mscomp {

/// Features say nothing about where a connected component lies: this moves each to where it
/// belongs, by what another shape knows or by what the features of its neighbours let expect.
class Placement {
  public:
    Placement(const OneRings& rings, std::vector<Point> reference);

    int component_count() const { return component_count_; }
    /// (V) numbered from 0 in the order of their lowest vertex.
    const std::vector<int>& component() const { return component_; }
    /// Lowest vertex of every component.
    const std::vector<int>& first_vertices() const { return first_vertices_; }
    /// How far each component moves (C) to be joined to those before it. p_to - p_from of every
    /// link goes where the mean of the deformation gradients T of its ends takes it; the component
    /// moves by the mean of what its links want. Linear in positions and gradients together, both
    /// by vertex.
    std::vector<Eigen::Vector3d> shifts(const std::function<Eigen::Vector3d(int)>& position,
                                        const std::function<Eigen::Matrix3d(int)>& gradient) const;
    /// The adjoint of shifts(): hands derivatives by the shifts (C), which are overwritten, on to
    /// positions and gradients, to a vertex once per link that ends there.
    void take_back_shifts(
        std::vector<Eigen::Vector3d>& by_shift,
        const std::function<void(int, const Eigen::Vector3d&)>& add_to_position,
        const std::function<void(int, const Eigen::Matrix3d&)>& add_to_gradient) const;
    bool has_joints() const { return !joints_.empty(); }

    /// Moves every component of `positions` (V) so that its centroid is the one it has in `like`
    /// (V), or in the reference if that is empty; components marked in `left_alone` (C, or empty)
    /// stay. Throws MeshError if `like` has another V.
    void apply(std::span<const Point> like, std::vector<Point>& positions,
               const std::vector<char>& left_alone = {}) const;
    /// Joins the components, given the deformation gradients T (V), and moves the whole to the
    /// centroid that it has in `like` (V), or in the reference if that is empty. With one component
    /// the same as apply(). Throws as that does.
    void join(const std::vector<Eigen::Matrix3d>& gradients, std::span<const Point> like,
              std::vector<Point>& positions) const;

  private:
    /// p_to - p_from in the reference.
    Eigen::Vector3d edge(const PieceLink& link) const;
    void check_size(std::span<const Point> like) const;
    std::vector<Point> centroids(std::span<const Point> positions) const;

    std::vector<int> component_;
    std::vector<int> first_vertices_;
    int component_count_ = 0;
    std::vector<PieceJoint> joints_;
    std::vector<Point> reference_;
    std::vector<Point> reference_centroids_;
};

}  // namespace mscomp

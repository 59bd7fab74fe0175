// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "feature_lanes.h"
#include "linear_positions.h"

namespace mscomp {

/// The linear map of LinearPositions and its adjoint for up to kSize shapes, whose numbers lie side
/// by side and whose right-hand sides fill whole blocks of lanes. What comes out for a shape is the
/// same bit for bit whatever the others are. Keeps its memory from one use to the next.
class PositionGroup {
  public:
    static constexpr std::size_t kSize = 8;
    using Matrices = NineLanes;

    static Eigen::Matrix3d matrix(const Matrices& matrices, std::size_t shape) {
        Eigen::Matrix3d result;
        for (std::size_t k = 0; k < 9; ++k) result.data()[k % 3 * 3 + k / 3] = matrices[k][shape];
        return result;
    }
    static void set_matrix(Matrices& matrices, std::size_t shape, const Eigen::Matrix3d& value) {
        for (std::size_t k = 0; k < 9; ++k) matrices[k][shape] = value.data()[k % 3 * 3 + k / 3];
    }

    /// Borrows.
    explicit PositionGroup(const LinearPositions& positions);

    /// From changes dT of the gradients to changes of the positions: clear(), add() of those that
    /// are not zero, once per vertex and shape, solve(), get().
    void clear();
    void add(std::size_t vertex, const Matrices& changes);
    void add(std::size_t vertex, std::size_t shape, const Eigen::Matrix3d& change);
    void solve();
    /// Overwrites `changes` (n,V,3) of the first n shapes; the mean of each is 0.
    void get(std::span<double> changes) const;

    /// From derivatives by the positions to those by the gradients: set() instead of clear(),
    /// solve_adjoint(), by_gradient() vertex by vertex.
    void set(std::span<const double> by_position);  // (n,V,3)
    void solve_adjoint();
    void by_gradient(std::size_t vertex, Matrices& result) const;

  private:
    std::size_t vertex_count() const { return positions_.vertex_count(); }
    void add_to_row(std::size_t vertex, std::size_t shape, const Eigen::Vector3d& value);
    Eigen::Vector3d row(std::size_t vertex, std::size_t shape) const;
    /// One vector for each shape, coordinate by coordinate.
    using Vectors = std::array<Lanes<kSize>, 3>;

    std::vector<Vectors> shifts_of_components(std::size_t shape_count) const;
    void take_back_shifts(std::size_t shape_count);

    LinearPositions positions_;
    std::array<std::vector<Lanes<kSize>>, 3> rows_;  // (V) of each coordinate
    std::vector<Matrices> changes_;                  // (V), empty if nothing is joined
    std::vector<Lanes<kSize>> work_, scratch_;
};

}  // namespace mscomp

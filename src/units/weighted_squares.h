// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace mscomp {

/// Σ_i ω_i Y_iᵀ Y_i for many weights ω at a time. That is linear in ω: the products of all Y_i are
/// made once, r (r + 1) / 2 numbers of each place, and a sum is a product with them. The same bits
/// for every lane, in vectors of any width.
class WeightedSquares {
  public:
    static constexpr int kLanes = 32;

    /// Y_i are `width` rows of `places` (width n,r) one after the other.
    WeightedSquares(const Eigen::MatrixXd& places, int width);

    int directions() const { return directions_; }
    /// How long the sums of all lanes are.
    std::size_t sums_size() const { return squares_.size() / at_places_ * kLanes; }
    /// Of `weights` (n,kLanes), row by row, to `sums`.
    void add_up(const double* weights, double* sums) const;
    /// The lower triangle (r,r) of a lane of such sums; the upper one stays as it is.
    void lower(const double* sums, int lane, Eigen::MatrixXd& to) const;

  private:
    int directions_;
    std::size_t at_places_;        // n
    std::vector<double> squares_;  // entries of the lower triangle, a few together, place by place
};

}  // namespace mscomp

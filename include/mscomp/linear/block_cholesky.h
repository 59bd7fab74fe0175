// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace mscomp {

/// P A Pᵀ = L D Lᵀ of a symmetric positive definite matrix, factorised once (approximate minimum
/// degree order), solved for kLanes right-hand sides at a time: the factor is read once for all of
/// them. Each lane's result is the same whatever the other lanes hold. For 4 and 8 lanes.
template <std::size_t kLanes>
class BlockCholesky {
  public:
    using Lanes = std::array<double, kLanes>;

    /// `name` appears in the message. Throws NumericalError if A is not positive definite.
    BlockCholesky(const Eigen::SparseMatrix<double>& A, const std::string& name);

    /// Overwrites the (n, kLanes) right-hand sides `x` with A⁻¹ x; `work` is scratch. Safe to call
    /// from several threads.
    void solve(std::vector<Lanes>& x, std::vector<Lanes>& work) const;

  private:
    std::vector<int> position_;                // (n) of an unknown in the elimination order
    std::vector<int> column_begin_;            // (n+1) strictly lower part of L by columns
    std::vector<int> row_;                     // (nonzeros)
    std::vector<double> value_;                // (nonzeros)
    std::vector<double> inverse_of_diagonal_;  // (n) 1 / D
};

}  // namespace mscomp

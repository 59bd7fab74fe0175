// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace mscomp {

/// Right-hand sides solved together: the factor is read once for all of them.
inline constexpr std::size_t kLanes = 8;
using Lanes = std::array<double, kLanes>;

/// P A Pᵀ = L D Lᵀ of a symmetric positive definite matrix, factorised once (approximate minimum
/// degree order), solved for kLanes right-hand sides at a time. Each lane's result is the same
/// whatever the other lanes hold.
class BlockCholesky {
  public:
    /// `name` appears in the message. Throws NumericalError if A is not positive definite.
    BlockCholesky(const Eigen::SparseMatrix<double>& A, const std::string& name);

    /// Overwrites the (V, kLanes) right-hand sides `x` with A⁻¹ x; `work` is scratch.
    void solve(std::vector<Lanes>& x, std::vector<Lanes>& work) const;

  private:
    std::vector<int> position_;                // (V) of a vertex in the elimination order
    std::vector<int> column_begin_;            // (V+1) strictly lower part of L by columns
    std::vector<int> row_;                     // (nonzeros)
    std::vector<double> value_;                // (nonzeros)
    std::vector<double> inverse_of_diagonal_;  // (V) 1 / D
};

}  // namespace mscomp

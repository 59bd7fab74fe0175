// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace mscomp {

/// In which order unknowns are eliminated.
enum class Elimination {
    automatic,          // the second from kLargeSystem unknowns on
    minimum_degree,     // quick to find, good for small systems
    nested_dissection,  // METIS, columns of equal pattern taken together: less work for large ones
};

/// Unknowns from which nested dissection is taken.
inline constexpr Eigen::Index kLargeSystem = 10'000;

/// Right-hand sides that are solved together lie side by side.
template <std::size_t kLanes>
using Lanes = std::array<double, kLanes>;

/// P A Pᵀ = L Lᵀ of a symmetric positive definite matrix, factorised once, solved for 1, 4 or 8
/// right-hand sides at a time: the factor is read once for all of them. Each lane's result is the
/// same bit for bit whatever the other lanes hold, how many there are, and on any processor.
class BlockCholesky {
  public:
    /// Only the lower triangle of A is looked at. `name` appears in messages. Throws NumericalError
    /// if A is not positive definite.
    BlockCholesky(const Eigen::SparseMatrix<double>& A, const std::string& name,
                  Elimination elimination = Elimination::automatic);
    /// Eliminates as `like` does where that order was costly to find (nested dissection): A has the
    /// same size and about the same pattern.
    BlockCholesky(const Eigen::SparseMatrix<double>& A, const std::string& name,
                  const BlockCholesky& like);
    BlockCholesky(BlockCholesky&&) noexcept;
    BlockCholesky& operator=(BlockCholesky&&) noexcept;
    ~BlockCholesky();

    /// Overwrites the (n, kLanes) right-hand sides `x` with A⁻¹ x; `work` is scratch. Safe to call
    /// from several threads.
    template <std::size_t kLanes>
    void solve(std::vector<Lanes<kLanes>>& x, std::vector<Lanes<kLanes>>& work) const;

    /// The two halves of solve() for A = C Cᵀ, C = Pᵀ L: overwrite b by C⁻¹ b, and y by C⁻ᵀ y. So
    /// x -> Cᵀ x are the variables in which A is the identity: |C⁻¹ b|² = bᵀ A⁻¹ b. Rows of y stand
    /// in the order of elimination. Promises as of solve().
    template <std::size_t kLanes>
    void solve_half(std::vector<Lanes<kLanes>>& b, std::vector<Lanes<kLanes>>& work) const;
    template <std::size_t kLanes>
    void solve_transposed_half(std::vector<Lanes<kLanes>>& y,
                               std::vector<Lanes<kLanes>>& work) const;

    /// minimum_degree or nested_dissection.
    Elimination elimination() const;
    /// Numbers below the diagonal of L that are stored, zeros among them.
    std::size_t stored_numbers() const;

  private:
    class Factor;
    class Simplicial;
    class Supernodal;

    std::unique_ptr<const Factor> factor_;
};

}  // namespace mscomp

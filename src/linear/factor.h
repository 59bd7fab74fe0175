// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <string>
#include <vector>

#include "mscomp/linear/block_cholesky.h"
#include "substitution.h"

struct cholmod_factor_struct;

namespace mscomp {

/// A factor in one of two layouts. Vectors are in the order of elimination.
class BlockCholesky::Factor {
  public:
    virtual ~Factor() = default;
    /// (n) step at which an unknown is eliminated.
    virtual const std::vector<int>& position() const = 0;
    /// Overwrites (n, lanes) with L⁻ᵀ L⁻¹ of it, for 1, 4 or 8 lanes.
    virtual void substitute(double* x, std::size_t lanes) const = 0;
    /// Overwrites (n, lanes) with L⁻¹ or L⁻ᵀ of it.
    virtual void substitute_forward(double* x, std::size_t lanes) const = 0;
    virtual void substitute_backward(double* x, std::size_t lanes) const = 0;
    virtual Elimination elimination() const = 0;
    virtual std::size_t stored_numbers() const = 0;
};

/// L D Lᵀ, column by column, by approximate minimum degree. The L of the base class is L D^½.
class BlockCholesky::Simplicial final : public Factor {
  public:
    Simplicial(const Eigen::SparseMatrix<double>& A, const std::string& name);
    const std::vector<int>& position() const override { return position_; }
    void substitute(double* x, std::size_t lanes) const override;
    void substitute_forward(double* x, std::size_t lanes) const override;
    void substitute_backward(double* x, std::size_t lanes) const override;
    Elimination elimination() const override { return Elimination::minimum_degree; }
    std::size_t stored_numbers() const override { return value_.size(); }

  private:
    SimplicialColumns columns() const;

    std::vector<int> position_;                // (n)
    std::vector<int> column_begin_;            // (n+1) strictly lower part of L by columns
    std::vector<int> row_;                     // (nonzeros)
    std::vector<double> value_;                // (nonzeros)
    std::vector<double> inverse_of_diagonal_;  // (n) 1 / D
    std::vector<double> root_of_diagonal_;     // (n) D^½
};

/// L Lᵀ in blocks of columns that have the same rows below, by nested dissection (CHOLMOD, METIS).
class BlockCholesky::Supernodal final : public Factor {
  public:
    /// Eliminates in the order of `like` if there is one.
    Supernodal(const Eigen::SparseMatrix<double>& A, const std::string& name,
               const Supernodal* like);
    const std::vector<int>& position() const override { return position_; }
    void substitute(double* x, std::size_t lanes) const override;
    void substitute_forward(double* x, std::size_t lanes) const override;
    void substitute_backward(double* x, std::size_t lanes) const override;
    Elimination elimination() const override { return Elimination::nested_dissection; }
    std::size_t stored_numbers() const override;

  private:
    struct Free {
        void operator()(cholmod_factor_struct* factor) const;
    };

    SupernodalRows rows() const;
    void turn_to_rows(const std::string& name);

    std::unique_ptr<cholmod_factor_struct, Free> factor_;
    std::vector<int> position_;                // (n)
    std::vector<double> inverse_of_diagonal_;  // (n) 1 / L_jj
};

}  // namespace mscomp

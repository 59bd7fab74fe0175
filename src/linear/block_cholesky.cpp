// SPDX-License-Identifier: MIT
#include "mscomp/linear/block_cholesky.h"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <cmath>

#include "mscomp/base/error.h"

namespace mscomp {

template <std::size_t kLanes>
BlockCholesky<kLanes>::BlockCholesky(const Eigen::SparseMatrix<double>& A,
                                     const std::string& name) {
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::AMDOrdering<int>>
        factor(A);
    const auto size = static_cast<std::size_t>(A.rows());
    if (factor.info() != Eigen::Success) {
        throw NumericalError(fmt::format("{} ({} rows) cannot be factorised", name, size));
    }
    const Eigen::SparseMatrix<double> L = factor.matrixL().nestedExpression();
    column_begin_.assign(1, 0);
    position_.resize(size);
    for (std::size_t j = 0; j < size; ++j) {
        const auto column = static_cast<Eigen::Index>(j);
        const double pivot = factor.vectorD()[column];
        if (!(pivot > 0) || !std::isfinite(pivot)) {
            throw NumericalError(
                fmt::format("pivot {} of {} is {}, wanted a positive number", j, name, pivot));
        }
        inverse_of_diagonal_.push_back(1 / pivot);
        position_[j] = factor.permutationP().indices()[column];
        for (Eigen::SparseMatrix<double>::InnerIterator it(L, column); it; ++it) {
            if (it.row() <= it.col()) continue;
            row_.push_back(static_cast<int>(it.row()));
            value_.push_back(it.value());
        }
        column_begin_.push_back(static_cast<int>(row_.size()));
    }
}

template <std::size_t kLanes>
void BlockCholesky<kLanes>::solve(std::vector<Lanes>& x, std::vector<Lanes>& work) const {
    const std::size_t size = position_.size();
    work.resize(size);
    for (std::size_t i = 0; i < size; ++i) work[static_cast<std::size_t>(position_[i])] = x[i];
    for (std::size_t j = 0; j < size; ++j) {
        const Lanes pivot = work[j];
        for (int k = column_begin_[j]; k < column_begin_[j + 1]; ++k) {
            const double value = value_[static_cast<std::size_t>(k)];
            Lanes& target = work[static_cast<std::size_t>(row_[static_cast<std::size_t>(k)])];
            for (std::size_t lane = 0; lane < kLanes; ++lane) target[lane] -= value * pivot[lane];
        }
    }
    for (std::size_t j = size; j-- > 0;) {
        Lanes sum = work[j];
        for (double& entry : sum) entry *= inverse_of_diagonal_[j];
        for (int k = column_begin_[j]; k < column_begin_[j + 1]; ++k) {
            const double value = value_[static_cast<std::size_t>(k)];
            const Lanes& solved = work[static_cast<std::size_t>(row_[static_cast<std::size_t>(k)])];
            for (std::size_t lane = 0; lane < kLanes; ++lane) sum[lane] -= value * solved[lane];
        }
        work[j] = sum;
    }
    for (std::size_t i = 0; i < size; ++i) x[i] = work[static_cast<std::size_t>(position_[i])];
}

template class BlockCholesky<4>;
template class BlockCholesky<8>;

}  // namespace mscomp

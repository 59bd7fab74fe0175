// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <cmath>

#include "factor.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"

namespace mscomp {

BlockCholesky::Simplicial::Simplicial(const Eigen::SparseMatrix<double>& A,
                                      const std::string& name) {
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::AMDOrdering<int>>
        factor(A);
    const auto size = at(A.rows());
    if (factor.info() != Eigen::Success) {
        throw NumericalError(fmt::format("{} ({} rows) cannot be factorised", name, size));
    }
    const auto& L = factor.matrixL().nestedExpression();
    const Eigen::VectorXd diagonal = factor.vectorD();  // which copies it
    column_begin_.reserve(size + 1);
    column_begin_.assign(1, 0);
    inverse_of_diagonal_.reserve(size);
    root_of_diagonal_.reserve(size);
    row_.reserve(at(L.nonZeros()));
    value_.reserve(at(L.nonZeros()));
    for (std::size_t j = 0; j < size; ++j) {
        const auto column = static_cast<Eigen::Index>(j);
        const double pivot = diagonal[column];
        if (!(pivot > 0) || !std::isfinite(pivot)) {
            throw NumericalError(
                fmt::format("pivot {} of {} is {}, wanted a positive number", j, name, pivot));
        }
        inverse_of_diagonal_.push_back(1 / pivot);
        root_of_diagonal_.push_back(std::sqrt(pivot));
        for (Eigen::SparseMatrix<double>::InnerIterator it(L, column); it; ++it) {
            if (it.row() <= it.col()) continue;
            row_.push_back(static_cast<int>(it.row()));
            value_.push_back(it.value());
        }
        column_begin_.push_back(static_cast<int>(row_.size()));
    }
    const auto& order = factor.permutationP().indices();
    position_.assign(order.data(), order.data() + order.size());
}

SimplicialColumns BlockCholesky::Simplicial::columns() const {
    return {position_.size(), column_begin_.data(), row_.data(), value_.data(),
            inverse_of_diagonal_.data()};
}

void BlockCholesky::Simplicial::substitute(double* x, std::size_t lanes) const {
    mscomp::substitute(columns(), x, lanes, Sweep::both);
}

void BlockCholesky::Simplicial::substitute_forward(double* x, std::size_t lanes) const {
    mscomp::substitute(columns(), x, lanes, Sweep::forward);
    for (std::size_t j = 0; j < position_.size(); ++j) {
        const double factor = root_of_diagonal_[j] * inverse_of_diagonal_[j];
        for (std::size_t lane = 0; lane < lanes; ++lane) x[j * lanes + lane] *= factor;
    }
}

void BlockCholesky::Simplicial::substitute_backward(double* x, std::size_t lanes) const {
    // The sweep divides by D.
    for (std::size_t j = 0; j < position_.size(); ++j) {
        const double factor = root_of_diagonal_[j];
        for (std::size_t lane = 0; lane < lanes; ++lane) x[j * lanes + lane] *= factor;
    }
    mscomp::substitute(columns(), x, lanes, Sweep::backward);
}

}  // namespace mscomp

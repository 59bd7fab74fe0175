// SPDX-License-Identifier: MIT
#include "mscomp/linear/block_cholesky.h"

#include "factor.h"
#include "mscomp/base/index.h"

namespace mscomp {

BlockCholesky::BlockCholesky(const Eigen::SparseMatrix<double>& A, const std::string& name,
                             Elimination elimination) {
    const bool large = elimination == Elimination::automatic
                           ? A.rows() >= kLargeSystem
                           : elimination == Elimination::nested_dissection;
    if (large) {
        factor_ = std::make_unique<Supernodal>(A, name, nullptr);
    } else {
        factor_ = std::make_unique<Simplicial>(A, name);
    }
}

BlockCholesky::BlockCholesky(const Eigen::SparseMatrix<double>& A, const std::string& name,
                             const BlockCholesky& like) {
    if (const auto* supernodal = dynamic_cast<const Supernodal*>(like.factor_.get())) {
        factor_ = std::make_unique<Supernodal>(A, name, supernodal);
    } else {
        factor_ = std::make_unique<Simplicial>(A, name);
    }
}

BlockCholesky::BlockCholesky(BlockCholesky&&) noexcept = default;
BlockCholesky& BlockCholesky::operator=(BlockCholesky&&) noexcept = default;
BlockCholesky::~BlockCholesky() = default;

namespace {

/// `to` (n): row position[i] is row i of `from`.
template <class Row>
void eliminate_in_order(const std::vector<int>& position, const std::vector<Row>& from,
                        std::vector<Row>& to) {
    to.resize(position.size());
    for (std::size_t i = 0; i < position.size(); ++i) to[at(position[i])] = from[i];
}

/// Its inverse.
template <class Row>
void put_back(const std::vector<int>& position, const std::vector<Row>& from,
              std::vector<Row>& to) {
    for (std::size_t i = 0; i < position.size(); ++i) to[i] = from[at(position[i])];
}

}  // namespace

template <std::size_t kLanes>
void BlockCholesky::solve(std::vector<Lanes<kLanes>>& x, std::vector<Lanes<kLanes>>& work) const {
    const std::vector<int>& position = factor_->position();
    if (position.empty()) return;
    eliminate_in_order(position, x, work);
    factor_->substitute(work.front().data(), kLanes);
    put_back(position, work, x);
}

template <std::size_t kLanes>
void BlockCholesky::solve_half(std::vector<Lanes<kLanes>>& b,
                               std::vector<Lanes<kLanes>>& work) const {
    const std::vector<int>& position = factor_->position();
    if (position.empty()) return;
    eliminate_in_order(position, b, work);
    factor_->substitute_forward(work.front().data(), kLanes);
    b.swap(work);
}

template <std::size_t kLanes>
void BlockCholesky::solve_transposed_half(std::vector<Lanes<kLanes>>& y,
                                          std::vector<Lanes<kLanes>>& work) const {
    const std::vector<int>& position = factor_->position();
    if (position.empty()) return;
    factor_->substitute_backward(y.front().data(), kLanes);
    work.resize(y.size());
    put_back(position, y, work);
    y.swap(work);
}

template void BlockCholesky::solve(std::vector<Lanes<1>>&, std::vector<Lanes<1>>&) const;
template void BlockCholesky::solve(std::vector<Lanes<4>>&, std::vector<Lanes<4>>&) const;
template void BlockCholesky::solve(std::vector<Lanes<8>>&, std::vector<Lanes<8>>&) const;
template void BlockCholesky::solve_half(std::vector<Lanes<1>>&, std::vector<Lanes<1>>&) const;
template void BlockCholesky::solve_half(std::vector<Lanes<4>>&, std::vector<Lanes<4>>&) const;
template void BlockCholesky::solve_half(std::vector<Lanes<8>>&, std::vector<Lanes<8>>&) const;
template void BlockCholesky::solve_transposed_half(std::vector<Lanes<1>>&,
                                                   std::vector<Lanes<1>>&) const;
template void BlockCholesky::solve_transposed_half(std::vector<Lanes<4>>&,
                                                   std::vector<Lanes<4>>&) const;
template void BlockCholesky::solve_transposed_half(std::vector<Lanes<8>>&,
                                                   std::vector<Lanes<8>>&) const;

Elimination BlockCholesky::elimination() const { return factor_->elimination(); }
std::size_t BlockCholesky::stored_numbers() const { return factor_->stored_numbers(); }

}  // namespace mscomp

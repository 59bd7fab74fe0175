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

template <std::size_t kLanes>
void BlockCholesky::solve(std::vector<Lanes<kLanes>>& x, std::vector<Lanes<kLanes>>& work) const {
    const std::vector<int>& position = factor_->position();
    if (position.empty()) return;
    work.resize(position.size());
    for (std::size_t i = 0; i < position.size(); ++i) {
        work[at(position[i])] = x[i];
    }
    factor_->substitute(work.front().data(), kLanes);
    for (std::size_t i = 0; i < position.size(); ++i) {
        x[i] = work[at(position[i])];
    }
}

template void BlockCholesky::solve(std::vector<Lanes<1>>&, std::vector<Lanes<1>>&) const;
template void BlockCholesky::solve(std::vector<Lanes<4>>&, std::vector<Lanes<4>>&) const;
template void BlockCholesky::solve(std::vector<Lanes<8>>&, std::vector<Lanes<8>>&) const;

Elimination BlockCholesky::elimination() const { return factor_->elimination(); }
std::size_t BlockCholesky::stored_numbers() const { return factor_->stored_numbers(); }

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include <cholmod.h>
#include <fmt/format.h>

#include <cmath>
#include <mutex>

#include "factor.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/linear/blas_threads.h"

namespace mscomp {
namespace {

/// CHOLMOD's settings and workspace.
class Workspace {
  public:
    Workspace() {
        cholmod_start(&common_);
        common_.print = 0;
        common_.supernodal = CHOLMOD_SUPERNODAL;
        common_.final_ll = 1;
        common_.nmethods = 1;
        common_.postorder = 1;
    }
    Workspace(const Workspace&) = delete;
    Workspace& operator=(const Workspace&) = delete;
    ~Workspace() { cholmod_finish(&common_); }

    cholmod_common* operator->() { return &common_; }
    cholmod_common* get() { return &common_; }

  private:
    cholmod_common common_{};
};

/// The lower triangle of A where it lies; CHOLMOD only reads it.
cholmod_sparse view_of(const Eigen::SparseMatrix<double>& A) {
    cholmod_sparse view{};
    view.nrow = view.ncol = at(A.rows());
    view.nzmax = at(A.nonZeros());
    view.p = const_cast<int*>(A.outerIndexPtr());
    view.i = const_cast<int*>(A.innerIndexPtr());
    view.x = const_cast<double*>(A.valuePtr());
    view.stype = -1;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = 1;
    view.packed = 1;
    return view;
}

cholmod_factor* analyze(cholmod_sparse& matrix, const cholmod_factor* like, Workspace& workspace) {
    if (like != nullptr) {
        workspace->method[0].ordering = CHOLMOD_GIVEN;
        return cholmod_analyze_p(&matrix, static_cast<int*>(like->Perm), nullptr, 0,
                                 workspace.get());
    }
    workspace->method[0].ordering = CHOLMOD_METIS;
    // METIS seeds and draws from the one random generator of the C library.
    static std::mutex mutex;
    const std::lock_guard<std::mutex> lock(mutex);
    return cholmod_analyze(&matrix, workspace.get());
}

std::string reason(int status) {
    if (status == CHOLMOD_OUT_OF_MEMORY) return "there is not enough memory";
    if (status == CHOLMOD_TOO_LARGE) return "the factor has over 2^31 numbers";
    return fmt::format("CHOLMOD reports {}", status);
}

}  // namespace

void BlockCholesky::Supernodal::Free::operator()(cholmod_factor_struct* factor) const {
    Workspace workspace;
    cholmod_free_factor(&factor, workspace.get());
}

BlockCholesky::Supernodal::Supernodal(const Eigen::SparseMatrix<double>& A, const std::string& name,
                                      const Supernodal* like) {
    pin_blas_threads();
    Workspace workspace;
    cholmod_sparse matrix = view_of(A);
    factor_.reset(analyze(matrix, like != nullptr ? like->factor_.get() : nullptr, workspace));
    const bool done = factor_ && cholmod_factorize(&matrix, factor_.get(), workspace.get()) != 0;
    if (!done || workspace->status < CHOLMOD_OK || factor_->is_super == 0) {
        throw NumericalError(fmt::format("{} ({} rows) cannot be factorised: {}", name, A.rows(),
                                         reason(workspace->status)));
    }
    if (factor_->minor < factor_->n) {
        throw NumericalError(
            fmt::format("pivot {} of {} is not a positive number", factor_->minor, name));
    }
    const int* order = static_cast<const int*>(factor_->Perm);
    position_.resize(factor_->n);
    for (std::size_t j = 0; j < position_.size(); ++j) {
        position_[at(order[j])] = static_cast<int>(j);
    }
    turn_to_rows(name);
}

/// Blocks come column by column. Row by row they are read in one stream.
void BlockCholesky::Supernodal::turn_to_rows(const std::string& name) {
    auto* values = static_cast<double*>(factor_->x);
    const SupernodalRows blocks = rows();
    inverse_of_diagonal_.resize(position_.size());
    std::vector<double> by_rows;
    for (std::size_t s = 0; s < blocks.count; ++s) {
        const auto first = at(blocks.first_column[s]);
        const std::size_t width = at(blocks.first_column[s + 1]) - first;
        const auto height = at(blocks.row_begin[s + 1] - blocks.row_begin[s]);
        double* block = values + blocks.value_begin[s];
        by_rows.resize(width * height);
        for (std::size_t k = 0; k < width; ++k) {
            for (std::size_t r = 0; r < height; ++r) by_rows[r * width + k] = block[k * height + r];
            const double pivot = by_rows[k * width + k];
            if (!(pivot > 0) || !std::isfinite(pivot)) {
                throw NumericalError(
                    fmt::format("pivot {} of {} is not a positive number", first + k, name));
            }
            inverse_of_diagonal_[first + k] = 1 / pivot;
        }
        std::copy(by_rows.begin(), by_rows.end(), block);
    }
}

SupernodalRows BlockCholesky::Supernodal::rows() const {
    return {factor_->nsuper,
            static_cast<const int*>(factor_->super),
            static_cast<const int*>(factor_->pi),
            static_cast<const int*>(factor_->px),
            static_cast<const int*>(factor_->s),
            static_cast<const double*>(factor_->x),
            inverse_of_diagonal_.data()};
}

void BlockCholesky::Supernodal::substitute(double* x, std::size_t lanes) const {
    mscomp::substitute(rows(), x, lanes, Sweep::both);
}

void BlockCholesky::Supernodal::substitute_forward(double* x, std::size_t lanes) const {
    mscomp::substitute(rows(), x, lanes, Sweep::forward);
}

void BlockCholesky::Supernodal::substitute_backward(double* x, std::size_t lanes) const {
    mscomp::substitute(rows(), x, lanes, Sweep::backward);
}

std::size_t BlockCholesky::Supernodal::stored_numbers() const { return factor_->xsize; }

}  // namespace mscomp

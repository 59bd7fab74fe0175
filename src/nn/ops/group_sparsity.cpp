// SPDX-License-Identifier: MIT
#include <cmath>

#include "batch.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "nn/ops.h"

namespace mscomp::nn {
namespace {

template <class T>
T norm(const T* vector) {
    T sum = 0;
    for (int c = 0; c < kFeatureDim; ++c) sum += vector[c] * vector[c];
    return std::sqrt(sum);
}

template <class T>
class GroupSparsity final : public Op<T> {
  public:
    GroupSparsity(Tape<T>& tape, Var weights, SparsityRows& sparsity, bool differentiable)
        : weights_(weights),
          sparsity_(sparsity),
          autoencoders_(tape.extents(weights)[0]),
          components_(tape.extents(weights)[1]),
          vertices_(tape.extents(weights)[2]),
          omega_(tape.result("group_sparsity", {autoencoders_}, differentiable)) {
        row_sums_.resize(at(autoencoders_ * components_));
        if (differentiable) {
            lambdas_.resize(at(autoencoders_ * components_ * vertices_));
        }
    }

    std::string_view name() const override { return "group_sparsity"; }
    Var output() const override { return omega_; }

    void forward(Tape<T>& tape) override {
        const std::int64_t rows = autoencoders_ * components_;
        rows_ = &sparsity_.focus(std::span<const T>(tape.value(weights_)));
        parallel_for(rows, [&](std::int64_t row) {
            const std::span<const int> acting = sparsity_.acting(row);
            const std::span<const double> length = sparsity_.lengths(row);
            double sum = 0;
            for (std::size_t n = 0; n < acting.size(); ++n) {
                const double lambda = weight(row, acting[n]);
                sum += lambda * length[n];
                if (!lambdas_.empty()) {
                    lambdas_[at(row * vertices_ + acting[n])] = static_cast<T>(lambda);
                }
            }
            row_sums_[at(row)] = sum;
        });
        for (std::int64_t a = 0; a < autoencoders_; ++a) {
            double sum = 0;
            for (std::int64_t k = 0; k < components_; ++k) {
                sum += row_sums_[at(a * components_ + k)];
            }
            tape.value(omega_)[at(a)] = static_cast<T>(sum / static_cast<double>(components_));
        }
    }

    void backward(Tape<T>& tape) override {
        parallel_for(autoencoders_ * components_, [&](std::int64_t row) {
            const T* c = tape.value(weights_).data() + row * vertices_ * kFeatureDim;
            T* dc = tape.grad(weights_).data() + row * vertices_ * kFeatureDim;
            const double factor = static_cast<double>(tape.grad(omega_)[at(row / components_)]) /
                                  static_cast<double>(components_);
            const std::span<const int> acting = sparsity_.acting(row);
            for (std::size_t n = 0; n < acting.size(); ++n) {
                const std::int64_t v = acting[n];
                const auto lambda = static_cast<double>(lambdas_[at(row * vertices_ + v)]);
                const double length = sparsity_.lengths(row)[n];
                if (!(lambda > 0) || length == 0) continue;
                const T scale = static_cast<T>(factor * lambda / length);
                for (int i = 0; i < kFeatureDim; ++i) {
                    dc[v * kFeatureDim + i] += scale * c[v * kFeatureDim + i];
                }
            }
        });
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> omega(at(autoencoders_), T{0});
        for (std::int64_t row = 0; row < autoencoders_ * components_; ++row) {
            const T* c = tape.value(weights_).data() + row * vertices_ * kFeatureDim;
            const SparsityRow around = sparsity_.row(sparsity_.centers()[at(row)]);
            for (int v = 0; v < vertices_; ++v) {
                omega[at(row / components_)] += static_cast<T>(around.weight(v)) *
                                                norm(c + v * kFeatureDim) /
                                                static_cast<T>(components_);
            }
        }
        return omega;
    }

  private:
    double weight(std::int64_t row, std::int64_t v) const {
        return (*rows_)[at(row)].weight(static_cast<int>(v));
    }

    Var weights_;
    SparsityRows& sparsity_;
    std::int64_t autoencoders_, components_, vertices_;
    Var omega_;
    const std::vector<SparsityRow>* rows_ = nullptr;  // of the last forward pass
    std::vector<double> row_sums_;
    // (A*K,V) where backward needs them: another level may end the rows before it comes.
    std::vector<T> lambdas_;
};

}  // namespace

template <class T>
Var group_sparsity(Tape<T>& tape, Var component_weights, SparsityRows& sparsity,
                   bool differentiable) {
    return record_op<GroupSparsity<T>>(tape, component_weights, sparsity, differentiable);
}

template Var group_sparsity(Tape<float>&, Var, SparsityRows&, bool);
template Var group_sparsity(Tape<double>&, Var, SparsityRows&, bool);

}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
// The fully connected layers of the VAE with any number of channels per vertex.
#include "../kernels/spectral_kernels.h"
#include "batch.h"
#include "mscomp/base/index.h"
#include "nn/spectral_ops.h"
#include "spectral_pieces.h"

namespace mscomp::nn {
namespace {

template <class T>
class ProjectMoments final : public Op<T> {
  public:
    ProjectMoments(Tape<T>& tape, Var f, Var weights, Var spread_weights)
        : f_(f),
          weights_{weights, spread_weights},
          size_(latent_size(tape, weights, f)),
          moments_(tape.result("moments", {2, size_.components, size_.lanes}, true)) {}

    std::string_view name() const override { return "project_moments"; }
    Var output() const override { return moments_; }

    void forward(Tape<T>& tape) override {
        const std::span<T> moments = tape.value(moments_);
        std::fill(moments.begin(), moments.end(), T{0});
        for (int which = 0; which < 2; ++which) {
            add_codes(size_, tape.value(weights_[which]).data(), tape.value(f_).data(), partials_,
                      moments.data() + which * size_.codes());
        }
    }

    void backward(Tape<T>& tape) override {
        for (int which = 0; which < 2; ++which) {
            const T* slope = tape.grad(moments_).data() + which * size_.codes();
            add_weight_gradient(size_, slope, tape.value(f_).data(),
                                tape.grad(weights_[which]).data());
            if (!tape.needs_grad(f_)) continue;
            expand_all(size_, tape.value(weights_[which]).data(), slope, true,
                       tape.grad(f_).data());
        }
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> moments;
        for (const Var weights : weights_) {
            for (std::int64_t k = 0; k < size_.components; ++k) {
                for (std::int64_t l = 0; l < size_.lanes; ++l) {
                    T sum = 0;
                    for (std::int64_t i = 0; i < size_.stride(); ++i) {
                        sum += tape.value(weights)[at(k * size_.stride() + i)] *
                               tape.value(f_)[at(i * size_.lanes + l)];
                    }
                    moments.push_back(sum);
                }
            }
        }
        return moments;
    }

  private:
    Var f_;
    std::array<Var, 2> weights_;
    LatentSize size_;
    Var moments_;
    AlignedVector<T> partials_;
};

template <class T>
class ExpandCodes final : public Op<T> {
  public:
    ExpandCodes(Tape<T>& tape, Var codes, Var weights)
        : codes_(codes),
          weights_(weights),
          size_(latent_size(tape, weights, codes)),
          rows_(tape.result("expanded_codes", {1, size_.vertices, size_.channels, size_.lanes},
                            true)) {}

    std::string_view name() const override { return "expand_codes"; }
    Var output() const override { return rows_; }

    void forward(Tape<T>& tape) override {
        expand_all(size_, tape.value(weights_).data(), tape.value(codes_).data(), false,
                   tape.value(rows_).data());
    }

    void backward(Tape<T>& tape) override {
        add_weight_gradient(size_, tape.value(codes_).data(), tape.grad(rows_).data(),
                            tape.grad(weights_).data());
        if (!tape.needs_grad(codes_)) return;
        add_codes(size_, tape.value(weights_).data(), tape.grad(rows_).data(), partials_,
                  tape.grad(codes_).data());
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> rows;
        for (std::int64_t i = 0; i < size_.stride(); ++i) {
            for (std::int64_t l = 0; l < size_.lanes; ++l) {
                T sum = 0;
                for (std::int64_t k = 0; k < size_.components; ++k) {
                    sum += tape.value(weights_)[at(k * size_.stride() + i)] *
                           tape.value(codes_)[at(k * size_.lanes + l)];
                }
                rows.push_back(sum);
            }
        }
        return rows;
    }

  private:
    Var codes_, weights_;
    LatentSize size_;
    Var rows_;
    AlignedVector<T> partials_;
};

}  // namespace

template <class T>
Var project_moments(Tape<T>& tape, Var f, Var component_weights, Var spread_weights) {
    return record_op<ProjectMoments<T>>(tape, f, component_weights, spread_weights);
}

template <class T>
Var expand_codes(Tape<T>& tape, Var codes, Var component_weights) {
    return record_op<ExpandCodes<T>>(tape, codes, component_weights);
}

template Var project_moments(Tape<float>&, Var, Var, Var);
template Var project_moments(Tape<double>&, Var, Var, Var);
template Var expand_codes(Tape<float>&, Var, Var);
template Var expand_codes(Tape<double>&, Var, Var);

}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "../kernels/kernels.h"
#include "../kernels/spectral_kernels.h"
#include "batch.h"
#include "mscomp/base/index.h"
#include "nn/spectral_ops.h"

namespace mscomp::nn {
namespace {

/// Chebyshev convolution with any order and any numbers of channels; the plain op that the fused
/// ones are tested against.
template <class T>
class ChebConv final : public Op<T> {
  public:
    ChebConv(Tape<T>& tape, const ScaledLaplacian<T>& laplacian, Var x, Var theta,
             Activation activation)
        : laplacian_(laplacian),
          x_(x),
          theta_(theta),
          use_tanh_(activation == Activation::tanh),
          order_(static_cast<int>(tape.extents(theta)[0])),
          in_(static_cast<int>(tape.extents(theta)[1])),
          out_(static_cast<int>(tape.extents(theta)[2])),
          vertices_(tape.extents(x)[1]),
          lanes_(static_cast<int>(tape.extents(x)[3])),
          y_(tape.result("cheb_conv", {1, vertices_, out_, lanes_}, true)) {
        terms_.resize(at(order_ * vertices_ * in_ * lanes_));
    }

    std::string_view name() const override { return "cheb_conv"; }
    Var output() const override { return y_; }

    void forward(Tape<T>& tape) override {
        std::copy(tape.value(x_).begin(), tape.value(x_).end(), terms_.begin());
        expand_terms(terms_, in_);
        for_each_chunk(1, vertices_, [&](std::int64_t, std::int64_t, int begin, int end) {
            for (std::int64_t v = begin; v < end; ++v) filter_vertex(tape, v);
            T* y = tape.value(y_).data() + begin * out_ * lanes_;
            if (use_tanh_) {
                kernels<T>().tanh_forward(y, std::int64_t{end - begin} * out_ * lanes_, y);
            }
        });
    }

    void backward(Tape<T>& tape) override {
        slopes_.resize(at(order_ * vertices_ * out_ * lanes_));
        const std::span<T> y = tape.value(y_), dy = tape.grad(y_);
        for (std::size_t i = 0; i < y.size(); ++i) {
            slopes_[i] = use_tanh_ ? dy[i] * (1 - y[i] * y[i]) : dy[i];
        }
        // The Laplacian is symmetric, and so are its polynomials.
        expand_terms(slopes_, out_);
        partials_.assign(at(chunk_count(vertices_) * order_ * in_ * out_), T{0});
        for_each_chunk(1, vertices_, [&](std::int64_t, std::int64_t chunk, int begin, int end) {
            T* partial = partials_.data() + chunk * order_ * in_ * out_;
            for (std::int64_t v = begin; v < end; ++v) backward_vertex(tape, v, partial);
        });
        add_partials(partials_.data(), chunk_count(vertices_), std::int64_t{order_} * in_ * out_,
                     tape.grad(theta_).data());
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> y(at(vertices_ * out_ * lanes_), T{0});
        const std::vector<T> x(tape.value(x_).begin(), tape.value(x_).end());
        std::vector<T> now = x, before;
        for (int h = 0; h < order_; ++h) {
            for (std::int64_t v = 0; v < vertices_; ++v) {
                for (int o = 0; o < out_; ++o) {
                    for (int c = 0; c < in_; ++c) {
                        for (int l = 0; l < lanes_; ++l) {
                            y[at((v * out_ + o) * lanes_ + l)] +=
                                now[at((v * in_ + c) * lanes_ + l)] *
                                tape.value(theta_)[at((h * in_ + c) * out_ + o)];
                        }
                    }
                }
            }
            std::vector<T> next = laplacian_times(now);
            for (std::size_t i = 0; h > 0 && i < next.size(); ++i)
                next[i] = 2 * next[i] - before[i];
            before = std::move(now);
            now = std::move(next);
        }
        for (T& value : y) value = use_tanh_ ? std::tanh(value) : value;
        return y;
    }

  private:
    /// Fills terms 1 .. H-1 behind term 0, rows of `channels` x lanes.
    void expand_terms(AlignedVector<T>& terms, int channels) {
        const int row = channels * lanes_;
        const std::int64_t size = vertices_ * row;
        for (int h = 1; h < order_; ++h) {
            T* to = terms.data() + h * size;
            for_each_chunk(1, vertices_, [&](std::int64_t, std::int64_t, int begin, int end) {
                laplacian_.next_term(h, to - size, h > 1 ? to - 2 * size : nullptr, row, begin, end,
                                     to + std::int64_t{begin} * row);
            });
        }
    }

    void filter_vertex(Tape<T>& tape, std::int64_t v) {
        T* y = tape.value(y_).data() + v * out_ * lanes_;
        std::fill_n(y, out_ * lanes_, T{0});
        for (int h = 0; h < order_; ++h) {
            const T* x = terms_.data() + (h * vertices_ + v) * in_ * lanes_;
            for (int c = 0; c < in_; ++c) {
                for (int o = 0; o < out_; ++o) {
                    const T weight = tape.value(theta_)[at((h * in_ + c) * out_ + o)];
                    for (int l = 0; l < lanes_; ++l)
                        y[o * lanes_ + l] += weight * x[c * lanes_ + l];
                }
            }
        }
    }

    void backward_vertex(Tape<T>& tape, std::int64_t v, T* theta_grad) {
        T* dx = tape.needs_grad(x_) ? tape.grad(x_).data() + v * in_ * lanes_ : nullptr;
        const T* x = terms_.data() + v * in_ * lanes_;
        for (int h = 0; h < order_; ++h) {
            const T* slope = slopes_.data() + (h * vertices_ + v) * out_ * lanes_;
            for (int c = 0; c < in_; ++c) {
                for (int o = 0; o < out_; ++o) {
                    const std::int64_t entry = (std::int64_t{h} * in_ + c) * out_ + o;
                    const T weight = tape.value(theta_)[at(entry)];
                    T sum = 0;
                    for (int l = 0; l < lanes_; ++l) {
                        sum += x[c * lanes_ + l] * slope[o * lanes_ + l];
                        if (dx) dx[c * lanes_ + l] += weight * slope[o * lanes_ + l];
                    }
                    theta_grad[entry] += sum;
                }
            }
        }
    }

    std::vector<T> laplacian_times(const std::vector<T>& x) const {
        std::vector<T> result;
        const auto row = static_cast<std::int64_t>(in_) * lanes_;
        const OneRings& rings = laplacian_.rings();
        for (std::int64_t v = 0; v < vertices_; ++v) {
            for (std::int64_t i = 0; i < row; ++i) {
                T sum = laplacian_.diagonal() * x[at(v * row + i)];
                for (int n = rings.offsets[at(v)]; n < rings.offsets[at(v) + 1]; ++n) {
                    sum += laplacian_.weights()[at(n)] * x[at(rings.neighbors[at(n)] * row + i)];
                }
                result.push_back(sum);
            }
        }
        return result;
    }

    const ScaledLaplacian<T>& laplacian_;
    Var x_, theta_;
    bool use_tanh_;
    int order_, in_, out_;
    std::int64_t vertices_;
    int lanes_;
    Var y_;
    AlignedVector<T> terms_, slopes_;  // (H,V,d,lanes); (H,V,d',lanes), from the first backward on
    AlignedVector<T> partials_;        // (chunks,H,d,d')
};

template <class T>
class TransposeFilters final : public Op<T> {
  public:
    TransposeFilters(Tape<T>& tape, Var theta)
        : theta_(theta),
          order_(tape.extents(theta)[0]),
          in_(tape.extents(theta)[1]),
          out_(tape.extents(theta)[2]),
          transposed_(tape.result("transposed_filters", {order_, out_, in_}, true)) {}

    std::string_view name() const override { return "transpose_filters"; }
    Var output() const override { return transposed_; }

    void forward(Tape<T>& tape) override {
        for_each([&](std::size_t from, std::size_t to) {
            tape.value(transposed_)[to] = tape.value(theta_)[from];
        });
    }

    void backward(Tape<T>& tape) override {
        for_each([&](std::size_t from, std::size_t to) {
            tape.grad(theta_)[from] += tape.grad(transposed_)[to];
        });
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> result;
        for (std::int64_t h = 0; h < order_; ++h) {
            for (std::int64_t o = 0; o < out_; ++o) {
                for (std::int64_t c = 0; c < in_; ++c) {
                    result.push_back(tape.value(theta_)[at((h * in_ + c) * out_ + o)]);
                }
            }
        }
        return result;
    }

  private:
    template <class Visit>
    void for_each(Visit visit) const {
        for (std::int64_t h = 0; h < order_; ++h) {
            for (std::int64_t c = 0; c < in_; ++c) {
                for (std::int64_t o = 0; o < out_; ++o) {
                    visit(at((h * in_ + c) * out_ + o), at((h * out_ + o) * in_ + c));
                }
            }
        }
    }

    Var theta_;
    std::int64_t order_, in_, out_;
    Var transposed_;
};

}  // namespace

template <class T>
Var cheb_conv(Tape<T>& tape, const ScaledLaplacian<T>& laplacian, Var x, Var theta,
              Activation activation) {
    return record_op<ChebConv<T>>(tape, laplacian, x, theta, activation);
}

template <class T>
Var transpose_filters(Tape<T>& tape, Var theta) {
    return record_op<TransposeFilters<T>>(tape, theta);
}

template Var transpose_filters(Tape<float>&, Var);
template Var transpose_filters(Tape<double>&, Var);
template Var cheb_conv(Tape<float>&, const ScaledLaplacian<float>&, Var, Var, Activation);
template Var cheb_conv(Tape<double>&, const ScaledLaplacian<double>&, Var, Var, Activation);

}  // namespace mscomp::nn

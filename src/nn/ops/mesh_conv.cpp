// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <utility>

#include "../kernels/kernels.h"
#include "batch.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "nn/ops.h"

namespace mscomp::nn {
namespace {

constexpr int kMatrix = kFeatureDim * kFeatureDim;

template <class T>
using Matrix = std::array<T, kMatrix>;

template <class T>
Matrix<T> oriented(const T* w, bool transposed) {
    Matrix<T> m;
    for (int o = 0; o < kFeatureDim; ++o) {
        for (int c = 0; c < kFeatureDim; ++c) {
            const int from = transposed ? c * kFeatureDim + o : o * kFeatureDim + c;
            m[at(o * kFeatureDim + c)] = w[from];
        }
    }
    return m;
}

template <class T>
class MeshConv final : public Op<T> {
  public:
    MeshConv(Tape<T>& tape, const RingTable<T>& rings, Var x, Var w_own, Var w_ring, Var bias,
             bool transposed, Activation activation)
        : rings_(rings),
          x_(x),
          w_own_(w_own),
          w_ring_(w_ring),
          bias_(bias),
          transposed_(transposed),
          use_tanh_(activation == Activation::tanh),
          autoencoders_(tape.extents(x)[0]),
          vertices_(rings.vertex_count()),
          lanes_(static_cast<int>(tape.extents(x)[3])),
          y_(tape.result("mesh_conv", tape.extents(x), true)) {
        partials_.resize(at(autoencoders_ * chunk_count(vertices_)) * kPartial);
    }

    std::string_view name() const override { return "mesh_conv"; }
    Var output() const override { return y_; }

    void forward(Tape<T>& tape) override {
        const T* x = tape.value(x_).data();
        T* y = tape.value(y_).data();
        for_each_chunk(autoencoders_, vertices_, [&](std::int64_t a, std::int64_t, int b, int e) {
            const Matrix<T> mp = oriented(matrix(tape.value(w_own_), a), transposed_);
            const Matrix<T> mn = oriented(matrix(tape.value(w_ring_), a), transposed_);
            kernels<T>().conv_forward(neighborhood(), x + a * rows(), mp.data(), mn.data(),
                                      tape.value(bias_).data() + a * kFeatureDim, use_tanh_, lanes_,
                                      b, e, y + a * rows());
        });
    }

    void backward(Tape<T>& tape) override {
        const std::span<T> dpre = tape.scratch(autoencoders_ * rows());
        std::fill(partials_.begin(), partials_.end(), T{0});
        for_each_chunk(autoencoders_, vertices_, [&](std::int64_t a, std::int64_t c, int b, int e) {
            kernels<T>().conv_backward_activation(
                tape.value(y_).data() + a * rows(), tape.grad(y_).data() + a * rows(), use_tanh_,
                lanes_, b, e, dpre.data() + a * rows(), partial(a, c) + 2 * kMatrix);
        });
        T* dx = tape.needs_grad(x_) ? tape.grad(x_).data() : nullptr;
        for_each_chunk(autoencoders_, vertices_, [&](std::int64_t a, std::int64_t c, int b, int e) {
            thread_local AlignedVector<T> scratch;
            scratch.resize(at(kVertexChunk * kFeatureDim * lanes_));
            const Matrix<T> mp = oriented(matrix(tape.value(w_own_), a), transposed_);
            const Matrix<T> mn = oriented(matrix(tape.value(w_ring_), a), transposed_);
            kernels<T>().conv_backward(neighborhood(), tape.value(x_).data() + a * rows(),
                                       dpre.data() + a * rows(), mp.data(), mn.data(), lanes_, b, e,
                                       scratch.data(), dx ? dx + a * rows() : nullptr,
                                       partial(a, c), partial(a, c) + kMatrix);
        });
        for (std::int64_t a = 0; a < autoencoders_; ++a) add_parameter_gradients(tape, a);
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        const std::span<T> x = tape.value(x_);
        std::vector<T> y(x.size());
        const auto place = [&](std::int64_t a, std::int64_t v, int c, int l) {
            return at(a * rows() + (v * kFeatureDim + c) * lanes_ + l);
        };
        for (std::int64_t a = 0; a < autoencoders_; ++a) {
            const Matrix<T> mp = oriented(matrix(tape.value(w_own_), a), transposed_);
            const Matrix<T> mn = oriented(matrix(tape.value(w_ring_), a), transposed_);
            for (std::int64_t v = 0; v < vertices_; ++v) {
                for (int l = 0; l < lanes_; ++l) {
                    for (int o = 0; o < kFeatureDim; ++o) {
                        T sum = tape.value(bias_)[at(a * kFeatureDim + o)];
                        for (int c = 0; c < kFeatureDim; ++c) {
                            T mean = 0;
                            for (int n = rings_.rings.offsets[at(v)];
                                 n < rings_.rings.offsets[at(v) + 1]; ++n) {
                                mean += x[place(a, rings_.rings.neighbors[at(n)], c, l)];
                            }
                            mean *= rings_.inverse_degree[at(v)];
                            const auto i = at(o * kFeatureDim + c);
                            sum += mp[i] * x[place(a, v, c, l)] + mn[i] * mean;
                        }
                        y[place(a, v, o, l)] = use_tanh_ ? std::tanh(sum) : sum;
                    }
                }
            }
        }
        return y;
    }

  private:
    static constexpr int kPartial = 2 * kMatrix + kFeatureDim;

    std::int64_t rows() const { return vertices_ * kFeatureDim * lanes_; }
    static const T* matrix(std::span<T> all, std::int64_t a) { return all.data() + a * kMatrix; }
    T* partial(std::int64_t a, std::int64_t chunk) {
        return partials_.data() + (a * chunk_count(vertices_) + chunk) * kPartial;
    }
    Neighborhood<T> neighborhood() const {
        return {rings_.rings.offsets.data(), rings_.rings.neighbors.data(),
                rings_.inverse_degree.data()};
    }

    void add_parameter_gradients(Tape<T>& tape, std::int64_t a) {
        std::array<T, kPartial> sums{};
        add_partials(partial(a, 0), chunk_count(vertices_), std::int64_t{kPartial}, sums.data());
        const Matrix<T> own = oriented(sums.data(), transposed_);
        const Matrix<T> ring = oriented(sums.data() + kMatrix, transposed_);
        for (std::size_t i = 0; i < kMatrix; ++i) {
            tape.grad(w_own_)[at(a) * kMatrix + i] += own[i];
            tape.grad(w_ring_)[at(a) * kMatrix + i] += ring[i];
        }
        for (std::size_t c = 0; c < kFeatureDim; ++c) {
            tape.grad(bias_)[at(a) * kFeatureDim + c] += sums[2 * kMatrix + c];
        }
    }

    const RingTable<T>& rings_;
    Var x_, w_own_, w_ring_, bias_;
    bool transposed_, use_tanh_;
    std::int64_t autoencoders_, vertices_;
    int lanes_;
    Var y_;
    AlignedVector<T> partials_;  // (A, chunks, 81 + 81 + 9)
};

}  // namespace

template <class T>
RingTable<T>::RingTable(OneRings one_rings) : rings(std::move(one_rings)) {
    inverse_degree.resize(at(rings.vertex_count()));
    for (int v = 0; v < rings.vertex_count(); ++v) {
        const int degree = rings.degree(v);
        inverse_degree[at(v)] = degree > 0 ? T{1} / static_cast<T>(degree) : T{0};
    }
}

template <class T>
Var mesh_conv(Tape<T>& tape, const RingTable<T>& rings, Var x, Var w_own, Var w_ring, Var bias,
              bool transposed, Activation activation) {
    return record_op<MeshConv<T>>(tape, rings, x, w_own, w_ring, bias, transposed, activation);
}

template struct RingTable<float>;
template struct RingTable<double>;
template Var mesh_conv(Tape<float>&, const RingTable<float>&, Var, Var, Var, Var, bool, Activation);
template Var mesh_conv(Tape<double>&, const RingTable<double>&, Var, Var, Var, Var, bool,
                       Activation);

}  // namespace mscomp::nn

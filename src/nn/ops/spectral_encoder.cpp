// SPDX-License-Identifier: MIT
#include <cmath>

#include "../kernels/spectral_kernels.h"
#include "batch.h"
#include "mscomp/base/index.h"
#include "nn/spectral_ops.h"
#include "spectral_filters.h"

namespace mscomp::nn {
namespace {

template <class T>
class SpectralEncoder final : public Op<T> {
  public:
    SpectralEncoder(Tape<T>& tape, const BatchTerms<T>& terms, Var theta, Var weights,
                    Var spread_weights)
        : terms_(terms),
          theta_(theta),
          weights_{weights, spread_weights},
          size_{static_cast<int>(tape.extents(weights)[1]), kFeatureDim, terms.lanes(),
                terms.vertex_count()},
          moments_(tape.result("moments", {2, size_.components, size_.lanes}, true)),
          filter_gradient_(chunk_count(size_.vertices), terms.order()) {
        f_.resize(at(size_.stride() * size_.lanes));
        partials_.resize(at(chunk_count(size_.vertices) * 2 * size_.codes()));
    }

    std::string_view name() const override { return "spectral_encoder"; }
    Var output() const override { return moments_; }

    void forward(Tape<T>& tape) override {
        const SpectralKernels<T>& k = spectral_kernels<T>();
        for_each_chunk(
            1, size_.vertices, [&](std::int64_t, std::int64_t chunk, int begin, int end) {
                T* partial = partials_.data() + chunk * 2 * size_.codes();
                std::fill_n(partial, 2 * size_.codes(), T{0});
                for_each_piece(begin, end, [&](int v, int count) {
                    T* f = f_.data() + row(v);
                    k.filter(terms_at(v).data(), terms_.order(), tape.value(theta_).data(), true,
                             size_.lanes, count, f);
                    NextPiece<T> next(row(1), size_.vertices, v, count);
                    for (int h = 0; h < terms_.order(); ++h) next.add(terms_.term(h));
                    next.add(f_.data());
                    for (int which = 0; which < 2; ++which) {
                        k.project(weights_at(tape.value(weights_[which]), v), size_.stride(),
                                  size_.components, f, size_.lanes, count * kFeatureDim,
                                  next.ahead(), partial + which * size_.codes());
                    }
                });
            });
        std::fill(tape.value(moments_).begin(), tape.value(moments_).end(), T{0});
        add_blocks(partials_, chunk_count(size_.vertices), 2 * size_.codes(),
                   tape.value(moments_).data());
    }

    void backward(Tape<T>& tape) override {
        const SpectralKernels<T>& k = spectral_kernels<T>();
        for (int which = 0; which < 2; ++which) {
            transpose_codes(size_, slope(tape, which), transposed_[which]);
        }
        filter_gradient_.clear();
        for_each_chunk(
            1, size_.vertices, [&](std::int64_t, std::int64_t chunk, int begin, int end) {
                Scratch<T>& scratch = Scratch<T>::of_thread(size_);
                for_each_piece(begin, end, [&](int v, int count) {
                    T* pre = scratch.rows.data();
                    NextPiece<T> next(row(1), size_.vertices, v, count);
                    next.add(f_.data());
                    for (int h = 0; h < terms_.order(); ++h) next.add(terms_.term(h));
                    for (int which = 0; which < 2; ++which) {
                        k.expand(weights_at(tape.value(weights_[which]), v), size_.stride(),
                                 size_.components, slope(tape, which), size_.lanes,
                                 count * kFeatureDim, which > 0, next.ahead(), pre);
                    }
                    const T* f = f_.data() + row(v);
                    k.tanh_slope(f, row(count), pre);
                    for (int h = 0; h < terms_.order(); ++h) {
                        k.outer_9x9(terms_.term(h) + row(v), pre, size_.lanes, count,
                                    filter_gradient_.sums(chunk, h));
                    }
                    for (int which = 0; which < 2; ++which) {
                        k.outer(transposed_[which].data(), size_.padded(), size_.components, f,
                                size_.lanes, terms_.active(), count * kFeatureDim,
                                scratch.products.data(), size_.stride(),
                                weights_at(tape.grad(weights_[which]), v));
                    }
                });
            });
        filter_gradient_.add_to(tape.grad(theta_), T{1});
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> f;
        for (std::int64_t v = 0; v < size_.vertices; ++v) {
            for (int o = 0; o < kFeatureDim; ++o) {
                for (int l = 0; l < size_.lanes; ++l) {
                    T sum = 0;
                    for (int h = 0; h < terms_.order(); ++h) {
                        for (int c = 0; c < kFeatureDim; ++c) {
                            sum += terms_.term(h)[row(v) + c * size_.lanes + l] *
                                   tape.value(theta_)[at((h * kFeatureDim + c) * kFeatureDim + o)];
                        }
                    }
                    f.push_back(std::tanh(sum));
                }
            }
        }
        std::vector<T> moments;
        for (const Var weights : weights_) {
            for (std::int64_t k = 0; k < size_.components; ++k) {
                for (std::int64_t l = 0; l < size_.lanes; ++l) {
                    T sum = 0;
                    for (std::int64_t i = 0; i < size_.stride(); ++i) {
                        sum += tape.value(weights)[at(k * size_.stride() + i)] *
                               f[at(i * size_.lanes + l)];
                    }
                    moments.push_back(sum);
                }
            }
        }
        return moments;
    }

  private:
    std::int64_t row(std::int64_t v) const { return v * kFeatureDim * size_.lanes; }
    static T* weights_at(std::span<T> all, int v) {
        return all.data() + std::int64_t{v} * kFeatureDim;
    }
    const T* slope(Tape<T>& tape, int which) const {
        return tape.grad(moments_).data() + which * size_.codes();
    }
    std::array<const T*, kMostTerms> terms_at(int v) const {
        std::array<const T*, kMostTerms> place{};
        for (int h = 0; h < terms_.order(); ++h) {
            place[at(h)] = terms_.term(h) + row(v);
        }
        return place;
    }

    const BatchTerms<T>& terms_;
    Var theta_;
    std::array<Var, 2> weights_;
    LatentSize size_;
    Var moments_;
    FilterGradient<T> filter_gradient_;
    AlignedVector<T> f_;                          // (V,9,lanes)
    AlignedVector<T> partials_;                   // (chunks,2,K,lanes)
    std::array<AlignedVector<T>, 2> transposed_;  // gradients of the moments, (lanes,padded)
};

}  // namespace

template <class T>
BatchTerms<T>::BatchTerms(const ScaledLaplacian<T>& laplacian, int order, int lanes)
    : laplacian_(laplacian), lanes_(lanes), terms_(at(order)) {
    own_.resize(at((order - 1) * vertex_count() * kFeatureDim * lanes));
}

template <class T>
void BatchTerms<T>::prepare(std::span<const T> x, int active) {
    active_ = active;
    const int row = kFeatureDim * lanes_;
    terms_[0] = x.data();
    for (int h = 1; h < order(); ++h) {
        T* to = own_.data() + (h - 1) * vertex_count() * row;
        for_each_chunk(1, vertex_count(), [&](std::int64_t, std::int64_t, int begin, int end) {
            laplacian_.next_term(h, term(h - 1), h > 1 ? term(h - 2) : nullptr, row, begin, end,
                                 to + std::int64_t{begin} * row);
        });
        terms_[at(h)] = to;
    }
}

template <class T>
Var spectral_encoder(Tape<T>& tape, const BatchTerms<T>& terms, Var theta, Var component_weights,
                     Var spread_weights) {
    return record_op<SpectralEncoder<T>>(tape, terms, theta, component_weights, spread_weights);
}

template class BatchTerms<float>;
template class BatchTerms<double>;
template Var spectral_encoder(Tape<float>&, const BatchTerms<float>&, Var, Var, Var);
template Var spectral_encoder(Tape<double>&, const BatchTerms<double>&, Var, Var, Var);

}  // namespace mscomp::nn

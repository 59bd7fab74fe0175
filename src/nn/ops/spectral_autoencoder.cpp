// SPDX-License-Identifier: MIT
// The two halves of the spectral autoencoder as one op each: pieces of sixteen vertices go through
// all that is done at a vertex while they are in cache, so that of all that lies between two
// formulas only f, C^T z and its Chebyshev terms are ever stored.
#include <cmath>

#include "../kernels/spectral_kernels.h"
#include "batch.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/nn/spectral_ops.h"
#include "spectral_pieces.h"

namespace mscomp::nn {
namespace {

constexpr int kMatrix = kFeatureDim * kFeatureDim;
constexpr int kColumns = 16;  // of the sums of outer_9x9

/// Scratch of one task; kept by its thread, so that a step allocates nothing.
template <class T>
struct Scratch {
    AlignedVector<T> rows, second_rows, products;

    static Scratch& of_thread(const LatentSize& size) {
        thread_local Scratch scratch;
        const auto rows = static_cast<std::size_t>(kPiece * kFeatureDim * size.lanes);
        scratch.rows.resize(std::max(scratch.rows.size(), rows));
        scratch.second_rows.resize(std::max(scratch.second_rows.size(), rows));
        const auto products = static_cast<std::size_t>(kPiece * kFeatureDim * size.padded());
        scratch.products.resize(std::max(scratch.products.size(), products));
        return scratch;
    }
};

/// Gradient of filters (H,9,9), summed per chunk over 16 columns.
template <class T>
class FilterGradient {
  public:
    FilterGradient(std::int64_t chunks, int order) : chunks_(chunks), order_(order) {
        sums_.resize(static_cast<std::size_t>(chunks * order * kMatrix * kColumns));
    }
    void clear() { std::fill(sums_.begin(), sums_.end(), T{0}); }
    T* sums(std::int64_t chunk, int degree) {
        return sums_.data() + (chunk * order_ + degree) * kMatrix * kColumns;
    }
    /// theta_grad += factor * sums.
    void add_to(std::span<T> theta_grad, T factor) const {
        for (std::int64_t i = 0; i < std::int64_t{order_} * kMatrix; ++i) {
            double sum = 0;
            for (std::int64_t chunk = 0; chunk < chunks_; ++chunk) {
                const T* columns = sums_.data() + (chunk * order_ * kMatrix + i) * kColumns;
                for (int n = 0; n < kColumns; ++n) sum += static_cast<double>(columns[n]);
            }
            theta_grad[static_cast<std::size_t>(i)] += factor * static_cast<T>(sum);
        }
    }

  private:
    std::int64_t chunks_;
    int order_;
    AlignedVector<T> sums_;
};

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
        f_.resize(static_cast<std::size_t>(size_.stride() * size_.lanes));
        partials_.resize(static_cast<std::size_t>(chunk_count(size_.vertices) * 2 * size_.codes()));
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
                                   tape.value(theta_)[static_cast<std::size_t>(
                                       (h * kFeatureDim + c) * kFeatureDim + o)];
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
                        sum +=
                            tape.value(weights)[static_cast<std::size_t>(k * size_.stride() + i)] *
                            f[static_cast<std::size_t>(i * size_.lanes + l)];
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
        std::array<const T*, kMostTerms> at{};
        for (int h = 0; h < terms_.order(); ++h) {
            at[static_cast<std::size_t>(h)] = terms_.term(h) + row(v);
        }
        return at;
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

template <class T>
class SpectralDecoder final : public Op<T> {
  public:
    SpectralDecoder(Tape<T>& tape, const ScaledLaplacian<T>& laplacian, Var codes, Var weights,
                    Var theta, Var x, const LaneMask<T>& lane_mask)
        : laplacian_(laplacian),
          codes_(codes),
          weights_(weights),
          theta_(theta),
          x_(x),
          lane_mask_(lane_mask),
          order_(static_cast<int>(tape.extents(theta)[0])),
          size_(latent_size(tape, weights, codes)),
          chunks_(chunk_count(size_.vertices)),
          error_(tape.result("squared_error", {1}, true)),
          filter_gradient_(chunks_, order_),
          errors_(static_cast<std::size_t>(chunks_)) {
        // The last term of a piece lives in scratch; there is always room for the first.
        terms_.resize(static_cast<std::size_t>(std::max(1, order_ - 1) * row(size_.vertices)));
        slope_.resize(static_cast<std::size_t>(row(size_.vertices)));
        partials_.resize(static_cast<std::size_t>(chunks_ * size_.codes()));
        theta_back_.resize(tape.value(theta).size());
    }

    std::string_view name() const override { return "spectral_decoder"; }
    Var output() const override { return error_; }

    void forward(Tape<T>& tape) override {
        const SpectralKernels<T>& k = spectral_kernels<T>();
        for_each_chunk(1, size_.vertices, [&](std::int64_t, std::int64_t, int begin, int end) {
            for_each_piece(begin, end, [&](int v, int count) {
                NextPiece<T> next(row(1), size_.vertices, v, count);
                next.add(term(0));
                k.expand(tape.value(weights_).data() + std::int64_t{v} * kFeatureDim,
                         size_.stride(), size_.components, tape.value(codes_).data(), size_.lanes,
                         count * kFeatureDim, false, next.ahead(), term(0) + row(v));
            });
        });
        store_inner_terms(term(0));
        const T factor = T{2} / static_cast<T>(lane_mask_.active);
        for_each_chunk(
            1, size_.vertices, [&](std::int64_t, std::int64_t chunk, int begin, int end) {
                Scratch<T>& scratch = Scratch<T>::of_thread(size_);
                double sum = 0;
                for_each_piece(begin, end, [&](int v, int count) {
                    T* out = slope_.data() + row(v);
                    k.filter(all_terms(term(0), v, count, scratch).data(), order_,
                             tape.value(theta_).data(), true, size_.lanes, count, out);
                    sum += k.error_slope(tape.value(x_).data() + row(v), lane_mask_.weight.data(),
                                         factor, size_.lanes, count, out);
                });
                errors_[static_cast<std::size_t>(chunk)] = sum;
            });
        double total = 0;
        for (const double error : errors_) total += error;
        tape.value(error_)[0] = static_cast<T>(total / lane_mask_.active);
    }

    void backward(Tape<T>& tape) override {
        const SpectralKernels<T>& k = spectral_kernels<T>();
        const T upstream = tape.grad(error_)[0];
        for (int h = 0; h < order_; ++h) {
            for (int n = 0; n < kMatrix; ++n) {
                const int from = n % kFeatureDim * kFeatureDim + n / kFeatureDim;
                theta_back_[static_cast<std::size_t>(h * kMatrix + n)] =
                    upstream * tape.value(theta_)[static_cast<std::size_t>(h * kMatrix + from)];
            }
        }
        transpose_codes(size_, tape.value(codes_).data(), transposed_);
        filter_gradient_.clear();
        // By symmetry of L the terms of the slopes serve both gradients, and those of C^T z are
        // needed no more.
        store_inner_terms(slope_.data());
        for_each_chunk(1, size_.vertices,
                       [&](std::int64_t, std::int64_t chunk, int begin, int end) {
                           T* partial = partials_.data() + chunk * size_.codes();
                           std::fill_n(partial, size_.codes(), T{0});
                           for_each_piece(begin, end, [&](int v, int count) {
                               backward_piece(tape, k, chunk, v, count, partial);
                           });
                       });
        add_blocks(partials_, chunks_, size_.codes(), tape.grad(codes_).data());
        filter_gradient_.add_to(tape.grad(theta_), upstream);
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        Tape<T> plain;
        const auto copy = [&](Var var) {
            const Var made = plain.input(tape.name(var), tape.extents(var));
            std::copy(tape.value(var).begin(), tape.value(var).end(), plain.value(made).begin());
            return made;
        };
        const Var weights = copy(weights_), theta = copy(theta_), codes = copy(codes_);
        const Var expanded = expand_codes(plain, codes, weights);
        plain.ops()[0]->forward(plain);
        cheb_conv(plain, laplacian_, expanded, theta, Activation::tanh);
        const std::vector<T> decoded = plain.ops()[1]->reference(plain);
        T sum = 0;
        for (std::size_t i = 0; i < decoded.size(); ++i) {
            const T difference = decoded[i] - tape.value(x_)[i];
            sum += lane_mask_.weight[i % static_cast<std::size_t>(size_.lanes)] * difference *
                   difference;
        }
        return {sum / static_cast<T>(lane_mask_.active)};
    }

  private:
    std::int64_t row(std::int64_t v) const { return v * kFeatureDim * size_.lanes; }
    T* term(int degree) { return terms_.data() + degree * row(size_.vertices); }
    /// Term `degree` of `first`, which is term 0.
    T* term_of(T* first, int degree) { return degree == 0 ? first : term(degree); }

    /// Terms 1 .. H-2 of `first` for all vertices.
    void store_inner_terms(T* first) {
        const int numbers = kFeatureDim * size_.lanes;
        for (int h = 1; h + 1 < order_; ++h) {
            for_each_chunk(1, size_.vertices, [&](std::int64_t, std::int64_t, int begin, int end) {
                laplacian_.next_term(h, term_of(first, h - 1),
                                     h > 1 ? term_of(first, h - 2) : nullptr, numbers, begin, end,
                                     term(h) + row(begin));
            });
        }
    }

    /// Rows of a piece of all terms; the last is computed into scratch.
    std::array<const T*, kMostTerms> all_terms(T* first, int v, int count, Scratch<T>& scratch) {
        std::array<const T*, kMostTerms> terms{first + row(v)};
        for (int h = 1; h + 1 < order_; ++h) {
            terms[static_cast<std::size_t>(h)] = term(h) + row(v);
        }
        if (order_ > 1) {
            laplacian_.next_term(order_ - 1, term_of(first, order_ - 2),
                                 order_ > 2 ? term_of(first, order_ - 3) : nullptr,
                                 kFeatureDim * size_.lanes, v, v + count, scratch.rows.data());
            terms[static_cast<std::size_t>(order_ - 1)] = scratch.rows.data();
        }
        return terms;
    }

    void backward_piece(Tape<T>& tape, const SpectralKernels<T>& k, std::int64_t chunk, int v,
                        int count, T* partial) {
        Scratch<T>& scratch = Scratch<T>::of_thread(size_);
        const auto terms = all_terms(slope_.data(), v, count, scratch);
        T* expanded_slope = scratch.second_rows.data();
        k.filter(terms.data(), order_, theta_back_.data(), false, size_.lanes, count,
                 expanded_slope);
        for (int h = 0; h < order_; ++h) {
            k.outer_9x9(term(0) + row(v), terms[static_cast<std::size_t>(h)], size_.lanes, count,
                        filter_gradient_.sums(chunk, h));
        }
        const std::int64_t first = std::int64_t{v} * kFeatureDim;
        NextPiece<T> next(row(1), size_.vertices, v, count);
        next.add(term(0));
        next.add(slope_.data());
        if (order_ > 2) next.add(term(1));
        k.project(tape.value(weights_).data() + first, size_.stride(), size_.components,
                  expanded_slope, size_.lanes, count * kFeatureDim, next.ahead(), partial);
        k.outer(transposed_.data(), size_.padded(), size_.components, expanded_slope, size_.lanes,
                lane_mask_.active, count * kFeatureDim, scratch.products.data(), size_.stride(),
                tape.grad(weights_).data() + first);
    }

    const ScaledLaplacian<T>& laplacian_;
    Var codes_, weights_, theta_, x_;
    const LaneMask<T>& lane_mask_;
    int order_;
    LatentSize size_;
    std::int64_t chunks_;
    Var error_;
    FilterGradient<T> filter_gradient_;
    std::vector<double> errors_;  // per chunk
    AlignedVector<T> terms_;      // (max(1,H-1),V,9,lanes): of C^T z, later 1 .. of slope_
    AlignedVector<T> slope_;      // (V,9,lanes) of the loss by the convolution, upstream 1
    AlignedVector<T> partials_;   // (chunks,K,lanes)
    AlignedVector<T> transposed_;
    AlignedVector<T> theta_back_;  // transposed, times upstream
};

}  // namespace

template <class T>
BatchTerms<T>::BatchTerms(const ScaledLaplacian<T>& laplacian, int order, int lanes)
    : laplacian_(laplacian), lanes_(lanes), terms_(static_cast<std::size_t>(order)) {
    own_.resize(static_cast<std::size_t>((order - 1) * vertex_count() * kFeatureDim * lanes));
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
        terms_[static_cast<std::size_t>(h)] = to;
    }
}

template <class T>
Var spectral_encoder(Tape<T>& tape, const BatchTerms<T>& terms, Var theta, Var component_weights,
                     Var spread_weights) {
    return record_op<SpectralEncoder<T>>(tape, terms, theta, component_weights, spread_weights);
}

template <class T>
Var spectral_decoder(Tape<T>& tape, const ScaledLaplacian<T>& laplacian, Var codes,
                     Var component_weights, Var theta, Var x, const LaneMask<T>& lanes) {
    return record_op<SpectralDecoder<T>>(tape, laplacian, codes, component_weights, theta, x,
                                         lanes);
}

template class BatchTerms<float>;
template class BatchTerms<double>;
template Var spectral_encoder(Tape<float>&, const BatchTerms<float>&, Var, Var, Var);
template Var spectral_encoder(Tape<double>&, const BatchTerms<double>&, Var, Var, Var);
template Var spectral_decoder(Tape<float>&, const ScaledLaplacian<float>&, Var, Var, Var, Var,
                              const LaneMask<float>&);
template Var spectral_decoder(Tape<double>&, const ScaledLaplacian<double>&, Var, Var, Var, Var,
                              const LaneMask<double>&);

}  // namespace mscomp::nn

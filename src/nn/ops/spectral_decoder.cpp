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
          errors_(at(chunks_)) {
        // The last term of a piece lives in scratch; there is always room for the first.
        terms_.resize(at(std::max(1, order_ - 1) * row(size_.vertices)));
        slope_.resize(at(row(size_.vertices)));
        partials_.resize(at(chunks_ * size_.codes()));
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
                errors_[at(chunk)] = sum;
            });
        double total = 0;
        for (const double error : errors_) total += error;
        tape.value(error_)[0] = static_cast<T>(total / lane_mask_.active);
    }

    void backward(Tape<T>& tape) override {
        const SpectralKernels<T>& k = spectral_kernels<T>();
        const T upstream = tape.grad(error_)[0];
        for (int h = 0; h < order_; ++h) {
            for (int n = 0; n < kFilterSize; ++n) {
                const int from = n % kFeatureDim * kFeatureDim + n / kFeatureDim;
                theta_back_[at(h * kFilterSize + n)] =
                    upstream * tape.value(theta_)[at(h * kFilterSize + from)];
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
            sum += lane_mask_.weight[i % at(size_.lanes)] * difference * difference;
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
            terms[at(h)] = term(h) + row(v);
        }
        if (order_ > 1) {
            laplacian_.next_term(order_ - 1, term_of(first, order_ - 2),
                                 order_ > 2 ? term_of(first, order_ - 3) : nullptr,
                                 kFeatureDim * size_.lanes, v, v + count, scratch.rows.data());
            terms[at(order_ - 1)] = scratch.rows.data();
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
            k.outer_9x9(term(0) + row(v), terms[at(h)], size_.lanes, count,
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
Var spectral_decoder(Tape<T>& tape, const ScaledLaplacian<T>& laplacian, Var codes,
                     Var component_weights, Var theta, Var x, const LaneMask<T>& lanes) {
    return record_op<SpectralDecoder<T>>(tape, laplacian, codes, component_weights, theta, x,
                                         lanes);
}

template Var spectral_decoder(Tape<float>&, const ScaledLaplacian<float>&, Var, Var, Var, Var,
                              const LaneMask<float>&);
template Var spectral_decoder(Tape<double>&, const ScaledLaplacian<double>&, Var, Var, Var, Var,
                              const LaneMask<double>&);

}  // namespace mscomp::nn

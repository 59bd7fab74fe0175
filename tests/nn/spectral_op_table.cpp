// SPDX-License-Identifier: MIT
#include <algorithm>
#include <utility>

#include "gradient_check.h"
#include "op_table.h"

namespace mscomp::nn {
namespace {

constexpr int kComponents = 5;

template <class T>
std::int64_t vertices(const OpFixture<T>& f) {
    return f.laplacian->vertex_count();
}

template <class T>
std::int64_t lanes(const OpFixture<T>& f) {
    return static_cast<std::int64_t>(f.lanes.weight.size());
}

template <class T>
Var input(OpFixture<T>& f, const char* name, Extents extents, double scale,
          bool needs_grad = true) {
    const Var var = f.tape.input(name, std::move(extents), needs_grad);
    fill_random(f.tape, var, static_cast<std::uint64_t>(var.index), scale);
    if (needs_grad) f.inputs.push_back(var);
    return var;
}

template <class T>
Var rows(OpFixture<T>& f, const char* name, std::int64_t channels) {
    return input(f, name, {1, vertices(f), channels, lanes(f)}, 1.0);
}

template <class T>
Var weights(OpFixture<T>& f, const char* name, std::int64_t channels) {
    return input(f, name, {1, kComponents, vertices(f), channels}, 0.3);
}

template <class T>
Var filters(OpFixture<T>& f, std::int64_t order, std::int64_t in, std::int64_t out) {
    return input(f, "theta", {order, in, out}, 0.15);
}

template <class T>
Var moments(OpFixture<T>& f) {
    return input(f, "moments", {2, kComponents, lanes(f)}, 0.8);
}

template <class T>
void conv(OpFixture<T>& f, std::int64_t order, std::int64_t in, std::int64_t out,
          Activation activation) {
    const Var x = rows(f, "x", in);
    f.output = cheb_conv(f.tape, *f.laplacian, x, filters(f, order, in, out), activation);
}

template <class T>
void sample(OpFixture<T>& f, Spread spread) {
    const Var both = moments(f);
    f.output =
        sample_codes(f.tape, both, input(f, "noise", {1, kComponents, lanes(f)}, 1.0), spread);
}

/// A batch without gradient; zero in lanes without a shape, as the loader leaves them.
template <class T>
Var batch(OpFixture<T>& f) {
    const Var x = input(f, "x", {1, vertices(f), 9, lanes(f)}, 0.5, false);
    const std::span<T> values = f.tape.value(x);
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] *= f.lanes.weight[i % f.lanes.weight.size()];
    }
    return x;
}

template <class T>
void encoder(OpFixture<T>& f, int order) {
    f.terms = std::make_unique<BatchTerms<T>>(*f.laplacian, order, static_cast<int>(lanes(f)));
    f.terms->prepare(f.tape.value(batch(f)), f.lanes.active);
    const Var theta = filters(f, order, 9, 9), own = weights(f, "C", 9);
    f.output = spectral_encoder(f.tape, *f.terms, theta, own, weights(f, "C_std", 9));
}

template <class T>
void decoder(OpFixture<T>& f, int order) {
    const Var codes = input(f, "codes", {1, kComponents, lanes(f)}, 0.7);
    const Var own = weights(f, "C", 9), theta = filters(f, order, 9, 9);
    f.output = spectral_decoder(f.tape, *f.laplacian, codes, own, theta, batch(f), f.lanes);
}

/// Omega, whose gradient by the ranges is a definition and no slope; centres that no small step
/// moves.
template <class T>
void sparsity(OpFixture<T>& f, std::int64_t channels) {
    const Var c = weights(f, "C", channels);
    for (std::int64_t k = 0; k < kComponents; ++k) {
        const std::int64_t v = (5 * k + 3) % vertices(f);
        f.tape.value(c)[static_cast<std::size_t>((k * vertices(f) + v) * channels)] = T{4};
    }
    const Var ranges = f.tape.input("d", {kComponents}, true);
    std::fill_n(f.tape.value(ranges).begin(), kComponents, T(0.31));
    f.centers = std::make_unique<ComponentCenters<T>>(*f.distances, CenterRule::follow);
    f.output = learned_sparsity(f.tape, c, ranges, *f.centers, StraightThrough::outside, true);
}

}  // namespace

template <class T>
std::vector<OpCase<T>> spectral_op_table() {
    using F = OpFixture<T>;
    std::vector<OpCase<T>> table{
        {"cheb_conv tanh", [](F& f) { conv(f, 3, 9, 9, Activation::tanh); }},
        {"cheb_conv order 1", [](F& f) { conv(f, 1, 9, 9, Activation::none); }},
        {"cheb_conv order 4 9 to 5", [](F& f) { conv(f, 4, 9, 5, Activation::none); }},
        {"cheb_conv order 2 5 to 9", [](F& f) { conv(f, 2, 5, 9, Activation::tanh); }},
        {"transpose_filters",
         [](F& f) { f.output = transpose_filters(f.tape, filters(f, 3, 9, 5)); }},
        {"project_moments",
         [](F& f) {
             const Var x = rows(f, "f", 9), c = weights(f, "C", 9);
             f.output = project_moments(f.tape, x, c, weights(f, "C_std", 9));
         }},
        {"project_moments of 5 channels",
         [](F& f) {
             const Var x = rows(f, "f", 5), c = weights(f, "C", 5);
             f.output = project_moments(f.tape, x, c, weights(f, "C_std", 5));
         }},
        {"expand_codes",
         [](F& f) {
             const Var z = input(f, "codes", {1, kComponents, lanes(f)}, 1.0);
             f.output = expand_codes(f.tape, z, weights(f, "C", 9));
         }},
        {"expand_codes to 5 channels",
         [](F& f) {
             const Var z = input(f, "codes", {1, kComponents, lanes(f)}, 1.0);
             f.output = expand_codes(f.tape, z, weights(f, "C", 5));
         }},
        {"sample_codes", [](F& f) { sample(f, Spread::log_variance); }},
        {"sample_codes linear", [](F& f) { sample(f, Spread::linear); }},
        {"offset_spread", [](F& f) { f.output = offset_spread(f.tape, moments(f), -5.25); }},
        {"kl_divergence",
         [](F& f) {
             f.output = kl_divergence(f.tape, moments(f), Spread::log_variance, 0.0, f.lanes);
         }},
        {"kl_divergence linear",
         [](F& f) { f.output = kl_divergence(f.tape, moments(f), Spread::linear, 0.1, f.lanes); }},
        {"range_term sum",
         [](F& f) { f.output = range_term(f.tape, input(f, "d", {7}, 1.0), RangeTerm::sum); }},
        {"range_term l2",
         [](F& f) { f.output = range_term(f.tape, input(f, "d", {7}, 1.0), RangeTerm::l2); }},
        {"learned_sparsity", [](F& f) { sparsity(f, 9); }},
        {"learned_sparsity of 5 channels", [](F& f) { sparsity(f, 5); }},
        {"spectral_encoder", [](F& f) { encoder(f, 3); }},
        {"spectral_encoder order 1", [](F& f) { encoder(f, 1); }},
        {"spectral_encoder order 5", [](F& f) { encoder(f, 5); }},
        {"spectral_decoder", [](F& f) { decoder(f, 3); }},
        {"spectral_decoder order 1", [](F& f) { decoder(f, 1); }},
        {"spectral_decoder order 2", [](F& f) { decoder(f, 2); }},
        {"spectral_decoder order 5", [](F& f) { decoder(f, 5); }},
    };
    for (OpCase<T>& each : table) {
        each.samples = 12;
        // Chains of up to three products: codes, terms of degree 2, filters.
        each.rounded_terms *= 3;
    }
    return table;
}

template std::vector<OpCase<float>> spectral_op_table();
template std::vector<OpCase<double>> spectral_op_table();

}  // namespace mscomp::nn

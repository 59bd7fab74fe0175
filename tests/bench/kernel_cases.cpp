// SPDX-License-Identifier: MIT
#include "kernel_cases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "banded_sphere.h"
#include "nn/vertex_order.h"

namespace mscomp::nn {

KernelCases::KernelCases(const plain::Sizes& sizes)
    : sizes_(sizes), rows_(sizes.row(sizes.vertices, 0, 0)) {
    const OneRings given = one_rings_of_faces(sizes.vertices, banded_sphere(sizes.vertices).faces);
    const OneRings rings = reordered(given, reverse_cuthill_mckee(given));
    offsets_ = rings.offsets;
    neighbors_ = rings.neighbors;
    for (int v = 0; v < sizes.vertices; ++v) {
        inverse_degree_.push_back(1.0F / static_cast<float>(rings.degree(v)));
    }
    rings_ = {offsets_.data(), neighbors_.data(), inverse_degree_.data()};
    add_convolution();
    add_codes();
    add_losses();
    add_elementwise();
    const Autoencoder shared = autoencoder();
    add_encoder(shared);
    add_decoder(shared);
    add_input_gradient(shared);
    add_children(shared);
    add_spectral_convolution();
    add_spectral_codes();
    add_spectral_elementwise();
    add_spectral_sparsity();
}

const KernelCase& KernelCases::at(std::string_view name) const {
    for (const KernelCase& each : cases_) {
        if (each.name == name) return each;
    }
    throw std::out_of_range("no kernel of this name: " + std::string(name));
}

AlignedVector<float>& KernelCases::random(std::size_t count) {
    const CounterRandom random(17, arrays_.size());
    AlignedVector<float>& values = arrays_.emplace_back(count);
    for (std::size_t i = 0; i < count; ++i) {
        values[i] = static_cast<float>(1.9 * random.uniform(i) - 0.95);
    }
    return values;
}

KernelCase& KernelCases::add(std::string name, double flops, double bytes) {
    KernelCase& added = cases_.emplace_back();
    added.name = std::move(name);
    added.flops = flops;
    added.bytes = bytes;
    added.reset = [] {};
    return added;
}

KernelCases::Twice KernelCases::output(std::size_t count, const AlignedVector<float>* start) {
    AlignedVector<float>& fast = arrays_.emplace_back(count);
    AlignedVector<float>& plain = arrays_.emplace_back(count);
    KernelCase& last = cases_.back();
    last.fast_outputs.push_back(&fast);
    last.plain_outputs.push_back(&plain);
    last.reset = [before = std::move(last.reset), &fast, &plain, start] {
        before();
        for (AlignedVector<float>* each : {&fast, &plain}) {
            if (start) {
                *each = *start;
            } else {
                std::fill(each->begin(), each->end(), 0.0F);
            }
        }
    };
    last.reset();
    return {fast, plain};
}

void KernelCases::add_convolution() {
    const auto s = sizes_;
    const auto rings = rings_;
    const double points = static_cast<double>(s.vertices) * s.lanes;
    const double array = 4.0 * static_cast<double>(rows_);
    const double ring = 9 * (6 + 1);  // mean degree 6
    const AlignedVector<float>&x = random(rows_), &dpre = random(rows_);
    const AlignedVector<float>&mp = random(81), &mn = random(81), &bias = random(9);

    KernelCase& forward = add("conv_forward", points * (4 * 81 + ring + 9), 2 * array);
    const Twice y = output(rows_);
    forward.fast = [=, &x, &mp, &mn, &bias](const Kernels<float>& k) {
        k.conv_forward(rings, x.data(), mp.data(), mn.data(), bias.data(), true, s.lanes, 0,
                       s.vertices, y.fast.data());
    };
    forward.plain = [=, &x, &mp, &mn, &bias] {
        plain::conv_forward(s, rings, x.data(), mp.data(), mn.data(), bias.data(), y.plain.data());
    };

    KernelCase& activation = add("conv_backward_activation", points * 9 * 4, 3 * array);
    const Twice slope = output(rows_), bias_grad = output(9);
    activation.fast = [=, &x, &dpre](const Kernels<float>& k) {
        k.conv_backward_activation(x.data(), dpre.data(), true, s.lanes, 0, s.vertices,
                                   slope.fast.data(), bias_grad.fast.data());
    };
    activation.plain = [=, &x, &dpre] {
        plain::conv_backward_activation(s, x.data(), dpre.data(), slope.plain.data(),
                                        bias_grad.plain.data());
    };

    KernelCase& backward = add("conv_backward", points * (8 * 81 + 2 * ring + 9), 4 * array);
    const Twice dx = output(rows_), mp_grad = output(81), mn_grad = output(81);
    AlignedVector<float>& scratch = arrays_.emplace_back(rows_);
    backward.fast = [=, &x, &dpre, &mp, &mn, &scratch](const Kernels<float>& k) {
        k.conv_backward(rings, x.data(), dpre.data(), mp.data(), mn.data(), s.lanes, 0, s.vertices,
                        scratch.data(), dx.fast.data(), mp_grad.fast.data(), mn_grad.fast.data());
    };
    backward.plain = [=, &x, &dpre, &mp, &mn] {
        plain::conv_backward(s, rings, x.data(), dpre.data(), mp.data(), mn.data(), dx.plain.data(),
                             mp_grad.plain.data(), mn_grad.plain.data());
    };
}

void KernelCases::add_codes() {
    const auto s = sizes_;
    const std::size_t weight_count = s.weight(s.components, 0, 0);
    const std::size_t code_count = s.code(s.components, 0);
    const auto stride = static_cast<std::int64_t>(s.weight(1, 0, 0));
    const double flops = 2.0 * s.components * static_cast<double>(rows_);
    const double traffic = 4.0 * static_cast<double>(rows_ + weight_count);
    const AlignedVector<float>&weights = random(weight_count), &rows = random(rows_);
    const AlignedVector<float>& codes = random(code_count);

    KernelCase& project = add("project", flops, traffic);
    const Twice z = output(code_count);
    project.fast = [=, &weights, &rows](const Kernels<float>& k) {
        k.project(weights.data(), stride, s.components, rows.data(), s.lanes, 0, s.vertices,
                  z.fast.data());
    };
    project.plain = [=, &weights, &rows] {
        plain::project(s, weights.data(), rows.data(), z.plain.data());
    };

    KernelCase& expand = add("expand", flops, traffic);
    const Twice f = output(rows_);
    expand.fast = [=, &weights, &codes](const Kernels<float>& k) {
        k.expand(weights.data(), stride, s.components, codes.data(), s.lanes, 0, s.vertices, false,
                 f.fast.data());
    };
    expand.plain = [=, &weights, &codes] {
        plain::expand(s, weights.data(), codes.data(), f.plain.data());
    };

    KernelCase& outer = add("outer", flops, traffic);
    const Twice dc = output(weight_count);
    outer.fast = [=, &codes, &rows](const Kernels<float>& k) {
        k.outer(codes.data(), rows.data(), stride, s.components, s.lanes, 0, s.vertices,
                dc.fast.data());
    };
    outer.plain = [=, &codes, &rows] {
        plain::outer(s, codes.data(), rows.data(), dc.plain.data());
    };
}

void KernelCases::add_losses() {
    const auto s = sizes_;
    const double count = static_cast<double>(rows_), array = 4 * count;
    const AlignedVector<float>&x = random(rows_), &y = random(rows_), &dout = random(rows_);
    const AlignedVector<float>& mask = random(static_cast<std::size_t>(s.vertices));
    AlignedVector<float>& weight = random(static_cast<std::size_t>(s.lanes));
    std::fill(weight.begin(), weight.end(), 1.0F);
    weight.back() = 0;

    KernelCase& error = add("squared_error", 4 * count, 2 * array);
    const Twice total = output(1);
    error.fast = [=, &x, &y, &weight](const Kernels<float>& k) {
        total.fast[0] = static_cast<float>(
            k.squared_error(x.data(), y.data(), weight.data(), s.lanes, 0, s.vertices));
    };
    error.plain = [=, &x, &y, &weight] {
        total.plain[0] =
            static_cast<float>(plain::squared_error(s, x.data(), y.data(), weight.data()));
    };

    KernelCase& backward = add("squared_error_backward", 5 * count, 6 * array);
    const Twice dx = output(rows_), dy = output(rows_);
    backward.fast = [=, &x, &y, &weight](const Kernels<float>& k) {
        k.squared_error_backward(x.data(), y.data(), weight.data(), 0.5F, s.lanes, 0, s.vertices,
                                 dx.fast.data(), dy.fast.data());
    };
    backward.plain = [=, &x, &y, &weight] {
        plain::squared_error_backward(s, x.data(), y.data(), weight.data(), 0.5F, dx.plain.data(),
                                      dy.plain.data());
    };

    KernelCase& residual = add("masked_residual", 2 * count, 3 * array);
    const Twice out = output(rows_);
    residual.fast = [=, &x, &y, &mask](const Kernels<float>& k) {
        k.masked_residual(x.data(), y.data(), mask.data(), s.lanes, 0, s.vertices, out.fast.data());
    };
    residual.plain = [=, &x, &y, &mask] {
        plain::masked_residual(s, x.data(), y.data(), mask.data(), out.plain.data());
    };

    KernelCase& masked = add("masked_residual_backward", 7 * count, 7 * array);
    const Twice gx = output(rows_), gy = output(rows_);
    const Twice gm = output(static_cast<std::size_t>(s.vertices));
    masked.fast = [=, &x, &y, &mask, &dout](const Kernels<float>& k) {
        k.masked_residual_backward(x.data(), y.data(), mask.data(), dout.data(), s.lanes, 0,
                                   s.vertices, gx.fast.data(), gy.fast.data(), gm.fast.data());
    };
    masked.plain = [=, &x, &y, &mask, &dout] {
        plain::masked_residual_backward(s, x.data(), y.data(), mask.data(), dout.data(),
                                        gx.plain.data(), gy.plain.data(), gm.plain.data());
    };
}

void KernelCases::add_elementwise() {
    const auto count = static_cast<std::int64_t>(rows_);
    const double numbers = static_cast<double>(rows_);
    const AlignedVector<float>&x = random(rows_), &g = random(rows_);

    KernelCase& tanh = add("tanh_forward", numbers, 8 * numbers);
    const Twice y = output(rows_);
    tanh.fast = [=, &x](const Kernels<float>& k) {
        k.tanh_forward(x.data(), count, y.fast.data());
    };
    tanh.plain = [=, &x] { plain::tanh_forward(x.data(), count, y.plain.data()); };

    KernelCase& adam = add("adam", 14 * numbers, 28 * numbers);
    const Twice p = output(rows_, &x), m = output(rows_), v = output(rows_);
    adam.fast = [=, &g](const Kernels<float>& k) {
        k.adam(p.fast.data(), m.fast.data(), v.fast.data(), g.data(), count, 1e-3F, 0.9F, 0.999F,
               0.1F, 0.001F, 1e-8F);
    };
    adam.plain = [=, &g] {
        plain::adam(p.plain.data(), m.plain.data(), v.plain.data(), g.data(), count, 1e-3F, 0.9F,
                    0.999F, 0.1F, 0.001F, 1e-8F);
    };
}

double difference(const KernelCase& what, const Kernels<float>& kernels) {
    what.reset();
    what.fast(kernels);
    what.plain();
    double worst = 0;
    for (std::size_t i = 0; i < what.fast_outputs.size(); ++i) {
        const AlignedVector<float>&fast = *what.fast_outputs[i], &plain = *what.plain_outputs[i];
        double largest = 0, apart = 0;
        for (std::size_t j = 0; j < plain.size(); ++j) {
            const double gap =
                std::abs(static_cast<double>(fast[j]) - static_cast<double>(plain[j]));
            if (!std::isfinite(gap)) return std::numeric_limits<double>::quiet_NaN();
            apart = std::max(apart, gap);
            largest = std::max(largest, std::abs(static_cast<double>(plain[j])));
        }
        worst = std::max(worst, apart / largest);
    }
    return worst;
}

}  // namespace mscomp::nn

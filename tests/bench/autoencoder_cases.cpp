// SPDX-License-Identifier: MIT
// The kernels of a whole autoencoder among the cases.
#include <algorithm>
#include <numeric>

#include "kernel_cases.h"
#include "plain_autoencoder.h"

namespace mscomp::nn {
namespace {

constexpr double kRing = 9 * (6 + 1);  // sums over a ring of mean degree 6 and the mean

void scale(AlignedVector<float>& values, float factor) {
    for (float& value : values) value *= factor;
}

}  // namespace

KernelCases::Autoencoder KernelCases::autoencoder() {
    std::vector<int>& vertices = indices_.emplace_back(static_cast<std::size_t>(sizes_.vertices));
    std::iota(vertices.begin(), vertices.end(), 0);
    const AlignedVector<float>& source = random(rows_);
    const AlignedVector<float>& mask = random(static_cast<std::size_t>(sizes_.vertices));
    AlignedVector<float>& weight = random(static_cast<std::size_t>(sizes_.lanes));
    std::fill(weight.begin(), weight.end(), 1.0F);
    weight.back() = 0;
    Autoencoder made{};
    made.rows = {vertices.data(), offsets_.data(), neighbors_.data(), inverse_degree_.data(),
                 source.data(),   mask.data(),     sizes_.lanes};
    made.codes = {sizes_.components, (sizes_.components + 7) / 8 * 8};
    made.packed =
        static_cast<std::size_t>(sizes_.vertices) * 9 * static_cast<std::size_t>(made.codes.padded);
    made.acting = vertices.data();
    made.lane_weight = weight.data();
    return made;
}

/// Rows of `padded` numbers, zeros behind the last component.
AlignedVector<float>& KernelCases::random_components(const Autoencoder& shared, std::size_t rows) {
    const auto padded = static_cast<std::size_t>(shared.codes.padded);
    AlignedVector<float>& values = random(rows * padded);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (i % padded >= static_cast<std::size_t>(shared.codes.components)) values[i] = 0;
    }
    return values;
}

void KernelCases::add_encoder(const Autoencoder& shared) {
    const int slots = sizes_.vertices, components = sizes_.components, lanes = sizes_.lanes;
    const double points = static_cast<double>(slots) * lanes;
    const double traffic = 4.0 * static_cast<double>(shared.packed + 2 * rows_);
    const std::size_t rows = static_cast<std::size_t>(slots) * 9;
    const AlignedVector<float>& matrices = random(171);
    const AlignedVector<float>& packed = random_components(shared, rows);
    const ConvParameters<float> conv{matrices.data(), matrices.data() + 81, matrices.data() + 162};

    KernelCase& forward =
        add("autoencoder_encode", points * (kRing + 4 * 81 + 9 + 18.0 * components), traffic);
    const Twice f = output(rows_), codes = output(sizes_.code(components, 0));
    forward.fast = [=, &packed](const Kernels<float>& k) {
        k.autoencoder.encode(shared.rows, conv, packed.data(), shared.codes, shared.acting, 0,
                             slots, f.fast.data(), codes.fast.data());
    };
    forward.plain = [=, &packed] {
        plain::encode(shared.rows, conv, packed.data(), shared.codes, slots, f.plain.data(),
                      codes.plain.data());
    };

    // f turns into the gradient in place: with small codes it stays small however often it does.
    AlignedVector<float>& codes_grad = random(sizes_.code(components, 0));
    AlignedVector<float>& across =
        random_components(shared, static_cast<std::size_t>(sizes_.lanes));
    scale(codes_grad, 0.01F);
    for (int l = 0; l < sizes_.lanes; ++l) {
        for (int k = 0; k < components; ++k) {
            across[static_cast<std::size_t>(l * shared.codes.padded + k)] =
                codes_grad[sizes_.code(k, l)];
        }
    }
    const AlignedVector<float>& start = random(rows_);
    KernelCase& backward =
        add("autoencoder_encode_backward", points * (36.0 * components + 36), traffic * 1.5);
    const Twice g = output(rows_, &start), packed_grad = output(shared.packed), bias = output(9);
    backward.fast = [=, &packed, &codes_grad, &across](const Kernels<float>& k) {
        k.autoencoder.encode_backward(lanes, packed.data(), shared.codes, codes_grad.data(),
                                      across.data(), shared.acting, 0, slots, g.fast.data(),
                                      packed_grad.fast.data(), bias.fast.data());
    };
    backward.plain = [=, &packed, &codes_grad] {
        plain::encode_backward(lanes, packed.data(), shared.codes, codes_grad.data(), slots,
                               g.plain.data(), packed_grad.plain.data(), bias.plain.data());
    };
}

void KernelCases::add_decoder(const Autoencoder& shared) {
    const int slots = sizes_.vertices, components = sizes_.components;
    const double points = static_cast<double>(slots) * sizes_.lanes;
    const double traffic = 4.0 * static_cast<double>(shared.packed + 2 * rows_);
    const std::size_t code_count = sizes_.code(components, 0);
    const AlignedVector<float>& packed =
        random_components(shared, static_cast<std::size_t>(slots) * 9);
    const AlignedVector<float>&bias = random(9), &codes = random(code_count);

    KernelCase& forward = add("autoencoder_decode", points * (18.0 * components + 9 * 6), traffic);
    const Twice e = output(rows_), total = output(1);
    forward.fast = [=, &packed, &bias, &codes](const Kernels<float>& k) {
        total.fast[0] = static_cast<float>(
            k.autoencoder.decode(shared.rows, packed.data(), bias.data(), shared.codes,
                                 codes.data(), shared.lane_weight, 0, slots, e.fast.data()));
    };
    forward.plain = [=, &packed, &bias, &codes] {
        total.plain[0] = static_cast<float>(
            plain::decode(shared.rows, packed.data(), bias.data(), shared.codes, codes.data(),
                          shared.lane_weight, slots, e.plain.data()));
    };

    const AlignedVector<float>& across =
        random_components(shared, static_cast<std::size_t>(sizes_.lanes));
    const AlignedVector<float>& error = random(rows_);
    AlignedVector<float>& scratch = arrays_.emplace_back(sizes_.row(1, 0, 0));
    KernelCase& backward = add("autoencoder_decode_backward", points * (36.0 * components + 9 * 8),
                               traffic + 4.0 * static_cast<double>(rows_));
    const Twice matrix = output(shared.packed, &packed), g = output(rows_);
    const Twice codes_grad = output(code_count), bias_grad = output(9);
    backward.fast = [=, &across, &error, &scratch](const Kernels<float>& k) {
        k.autoencoder.decode_backward(shared.rows, matrix.fast.data(), shared.codes, across.data(),
                                      shared.lane_weight, 0.5F, error.data(), nullptr, nullptr, 0,
                                      slots, g.fast.data(), codes_grad.fast.data(),
                                      bias_grad.fast.data(), scratch.data());
    };
    backward.plain = [=, &across, &error] {
        plain::decode_backward(shared.rows, matrix.plain.data(), shared.codes, across.data(),
                               shared.lane_weight, 0.5F, error.data(), slots, g.plain.data(),
                               codes_grad.plain.data(), bias_grad.plain.data());
    };
}

void KernelCases::add_input_gradient(const Autoencoder& shared) {
    const int slots = sizes_.vertices;
    const double points = static_cast<double>(slots) * sizes_.lanes;
    const AlignedVector<float>&matrices = random(162), &p = random(rows_);
    const ConvParameters<float> conv{matrices.data(), matrices.data() + 81, nullptr};
    AlignedVector<float>& scratch = arrays_.emplace_back(sizes_.row(16, 0, 0));
    KernelCase& backward = add("autoencoder_conv_backward", points * (8 * 81 + 2 * kRing),
                               16.0 * static_cast<double>(rows_));
    const Twice dx = output(rows_), own = output(81), ring = output(81);
    backward.fast = [=, &p, &scratch](const Kernels<float>& k) {
        k.autoencoder.conv_backward(shared.rows, conv, p.data(), 0, slots, scratch.data(),
                                    dx.fast.data(), own.fast.data(), ring.fast.data());
    };
    backward.plain = [=, &p] {
        plain::conv_backward(shared.rows, conv, p.data(), slots, dx.plain.data(), own.plain.data(),
                             ring.plain.data());
    };
}

/// Five children, each with a slot at every second vertex.
void KernelCases::add_children(const Autoencoder& shared) {
    constexpr int kChildren = 5;
    const int vertices = sizes_.vertices, lanes = sizes_.lanes;
    const double array = 4.0 * static_cast<double>(rows_);
    const float* source = shared.rows.source;
    const float* weight = shared.lane_weight;

    KernelCase& sums = add("autoencoder_moments", 4.0 * static_cast<double>(rows_), array);
    const Twice moments = output(static_cast<std::size_t>(vertices) * 10);
    sums.fast = [=](const Kernels<float>& k) {
        k.autoencoder.moments(source, weight, lanes, 0, vertices, moments.fast.data());
    };
    sums.plain = [=] { plain::moments(source, weight, lanes, vertices, moments.plain.data()); };

    std::vector<int>& slot_of = indices_.emplace_back();
    for (int v = 0; v < vertices; ++v) slot_of.push_back(v % 2 == 0 ? v / 2 : -1);
    AlignedVector<float>& known = random(static_cast<std::size_t>(vertices) * 10);
    find_kernels<float>("generic")->autoencoder.moments(source, weight, lanes, 0, vertices,
                                                        known.data());
    KernelCase& gather =
        add("autoencoder_gather_children", (4.0 * kChildren / 2 + 2) * static_cast<double>(rows_),
            (2.0 + kChildren) * array);
    const Twice source_grad = output(rows_);
    std::vector<ChildGradient<float>>&fast = children_.emplace_back(),
    &slow = children_.emplace_back();
    for (int k = 0; k < kChildren; ++k) {
        const float* grad = random(sizes_.row(vertices / 2 + 1, 0, 0)).data();
        const float* constant = random(9).data();
        const Twice mask_grad = output(static_cast<std::size_t>(vertices));
        ChildGradient<float> child{slot_of.data(),        grad,     shared.rows.mask,
                                   mask_grad.fast.data(), constant, 0.05F};
        fast.push_back(child);
        child.mask_grad = mask_grad.plain.data();
        slow.push_back(child);
    }
    gather.fast = [=, &fast, &known](const Kernels<float>& k) {
        k.autoencoder.gather_children(source, known.data(), weight, lanes, fast.data(), kChildren,
                                      0, vertices, source_grad.fast.data());
    };
    gather.plain = [=, &slow, &known] {
        plain::gather_children(source, known.data(), weight, lanes, slow.data(), kChildren,
                               vertices, source_grad.plain.data());
    };
}

}  // namespace mscomp::nn

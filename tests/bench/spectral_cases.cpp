// SPDX-License-Identifier: MIT
// The spectral kernels among the cases: each with the instruction set of the table it is given.
#include <algorithm>
#include <array>
#include <numbers>

#include "kernel_cases.h"
#include "plain_spectral.h"

namespace mscomp::nn {
namespace {

const SpectralKernels<float>& beside(const Kernels<float>& kernels) {
    return *find_spectral_kernels<float>(kernels.instruction_set);
}

}  // namespace

void KernelCases::add_spectral_convolution() {
    const auto s = sizes_;
    const double points = static_cast<double>(s.vertices) * s.lanes;
    const double array = 4.0 * static_cast<double>(rows_);
    const AlignedVector<float>&x = random(rows_), &previous = random(rows_), &t2 = random(rows_);
    const AlignedVector<float>& weights = random(neighbors_.size());
    const GraphMatrix<float> matrix{s.vertices, offsets_.data(), neighbors_.data(), weights.data(),
                                    0.5F};

    KernelCase& laplacian = add("spectral_laplacian", points * 9 * (2 * 6 + 3), 3 * array);
    const Twice t = output(rows_);
    laplacian.fast = [=, &x, &previous](const Kernels<float>& k) {
        beside(k).laplacian(matrix, x.data(), 9 * s.lanes, 2, previous.data(), 0, s.vertices,
                            t.fast.data());
    };
    laplacian.plain = [=, &x, &previous] {
        plain::laplacian(s, matrix, x.data(), 2, previous.data(), t.plain.data());
    };

    constexpr int kOrder = 3;
    const std::array<const float*, kOrder> terms{x.data(), previous.data(), t2.data()};
    const AlignedVector<float>& theta = random(kOrder * 81);
    KernelCase& filter =
        add("spectral_filter", points * (2 * 81 * kOrder + 9), (kOrder + 1) * array);
    const Twice y = output(rows_);
    filter.fast = [=, &theta](const Kernels<float>& k) {
        beside(k).filter(terms.data(), kOrder, theta.data(), true, s.lanes, s.vertices,
                         y.fast.data());
    };
    filter.plain = [=, &theta] {
        plain::filter(s, terms.data(), kOrder, theta.data(), y.plain.data());
    };

    constexpr std::size_t kColumns = 16;
    AlignedVector<float>& columns = arrays_.emplace_back(81 * kColumns);
    KernelCase& outer = add("spectral_outer_9x9", points * 2 * 81, 2 * array);
    const Twice sums = output(81);
    outer.fast = [=, &x, &previous, &columns](const Kernels<float>& k) {
        std::fill(columns.begin(), columns.end(), 0.0F);
        beside(k).outer_9x9(x.data(), previous.data(), s.lanes, s.vertices, columns.data());
        for (std::size_t i = 0; i < 81 * kColumns; ++i) sums.fast[i / kColumns] += columns[i];
    };
    outer.plain = [=, &x, &previous] {
        plain::outer_9x9(s, x.data(), previous.data(), sums.plain.data());
    };
}

void KernelCases::add_spectral_codes() {
    const auto s = sizes_;
    const int count = 9 * s.vertices, active = s.lanes;
    const std::size_t weight_count = s.weight(s.components, 0, 0);
    const std::size_t code_count = s.code(s.components, 0);
    const auto stride = static_cast<std::int64_t>(s.weight(1, 0, 0));
    const double flops = 2.0 * s.components * static_cast<double>(rows_);
    const double traffic = 4.0 * static_cast<double>(rows_ + weight_count);
    const AlignedVector<float>&weights = random(weight_count), &rows = random(rows_);
    const AlignedVector<float>& codes = random(code_count);

    KernelCase& project = add("spectral_project", flops, traffic);
    const Twice z = output(code_count);
    project.fast = [=, &weights, &rows](const Kernels<float>& k) {
        Ahead nothing;
        beside(k).project(weights.data(), stride, s.components, rows.data(), s.lanes, count,
                          nothing, z.fast.data());
    };
    project.plain = [=, &weights, &rows] {
        plain::project(s, weights.data(), rows.data(), z.plain.data());
    };

    KernelCase& expand = add("spectral_expand", flops, traffic);
    const Twice f = output(rows_);
    expand.fast = [=, &weights, &codes](const Kernels<float>& k) {
        Ahead nothing;
        beside(k).expand(weights.data(), stride, s.components, codes.data(), s.lanes, count, false,
                         nothing, f.fast.data());
    };
    expand.plain = [=, &weights, &codes] {
        plain::expand(s, weights.data(), codes.data(), f.plain.data());
    };

    const int padded = (s.components + 15) / 16 * 16;
    AlignedVector<float>& across = arrays_.emplace_back(static_cast<std::size_t>(active * padded));
    for (int k = 0; k < s.components; ++k) {
        for (int l = 0; l < active; ++l) {
            across[static_cast<std::size_t>(l * padded + k)] = codes[s.code(k, l)];
        }
    }
    AlignedVector<float>& scratch = arrays_.emplace_back(static_cast<std::size_t>(count * padded));
    KernelCase& outer = add("spectral_outer", flops, traffic);
    const Twice grad = output(weight_count);
    outer.fast = [=, &rows, &across, &scratch](const Kernels<float>& k) {
        beside(k).outer(across.data(), padded, s.components, rows.data(), s.lanes, active, count,
                        scratch.data(), stride, grad.fast.data());
    };
    outer.plain = [=, &rows, &codes] {
        plain::outer(s, codes.data(), rows.data(), grad.plain.data());
    };
}

void KernelCases::add_spectral_elementwise() {
    const auto s = sizes_;
    const auto count = static_cast<std::int64_t>(rows_);
    const double numbers = static_cast<double>(rows_);
    const AlignedVector<float>&x = random(rows_), &start = random(rows_);
    AlignedVector<float>& y = random(rows_);
    // 1 - y^2 is 1 or -1, so that a slope neither grows nor dies out however often it is scaled.
    for (float& each : y) each = each < 0 ? 0 : std::numbers::sqrt2_v<float>;

    KernelCase& slope = add("spectral_tanh_slope", 3 * numbers, 12 * numbers);
    const Twice g = output(rows_, &start);
    slope.fast = [=, &y](const Kernels<float>& k) {
        beside(k).tanh_slope(y.data(), count, g.fast.data());
    };
    slope.plain = [=, &y] { plain::tanh_slope(y.data(), count, g.plain.data()); };

    AlignedVector<float>& weight = random(static_cast<std::size_t>(s.lanes));
    std::fill(weight.begin(), weight.end(), 1.0F);
    weight.back() = 0;
    KernelCase& error = add("spectral_error_slope", 8 * numbers, 12 * numbers);
    const Twice e = output(rows_, &start), total = output(1);
    error.fast = [=, &x, &weight](const Kernels<float>& k) {
        total.fast[0] = static_cast<float>(beside(k).error_slope(
            x.data(), weight.data(), 0.5F, s.lanes, s.vertices, e.fast.data()));
    };
    error.plain = [=, &x, &weight] {
        total.plain[0] = static_cast<float>(
            plain::error_slope(s, x.data(), weight.data(), 0.5F, e.plain.data()));
    };
}

/// As many vertices as there are numbers in a channel of all rows, nine numbers each.
void KernelCases::add_spectral_sparsity() {
    const int rows = sizes_.vertices * sizes_.lanes;
    const auto count = static_cast<std::size_t>(rows);
    constexpr double kRange = 0.4;
    constexpr float kBound = 0.01F;
    const AlignedVector<float>& x = random(rows_);
    AlignedVector<float>&moment2 = random(rows_), &known = random(count);
    for (float& each : moment2) each *= each;
    plain::lengths(x.data(), 9, rows, known.data());
    for (int v = 0; v < rows; ++v) distances_.push_back((v * 37 % 101) / 101.0);
    const double* distances = distances_.data();

    KernelCase& lengths = add("spectral_lengths", 19.0 * rows, 40.0 * rows);
    const Twice length = output(static_cast<std::size_t>(rows));
    lengths.fast = [=, &x](const Kernels<float>& k) {
        beside(k).lengths(x.data(), 9, rows, length.fast.data());
    };
    lengths.plain = [=, &x] { plain::lengths(x.data(), 9, rows, length.plain.data()); };

    KernelCase& outside = add("spectral_outside", rows, 12.0 * rows);
    const Twice sum = output(1);
    outside.fast = [=, &known](const Kernels<float>& k) {
        sum.fast[0] = static_cast<float>(beside(k).outside(distances, known.data(), kRange, rows));
    };
    outside.plain = [=, &known] {
        sum.plain[0] = static_cast<float>(plain::outside(distances, known.data(), kRange, rows));
    };

    // Both begin with a copy: weights shrunk again and again would end as numbers that are slow.
    KernelCase& shrink = add("spectral_shrink", 20.0 * rows, 120.0 * rows);
    const Twice w = output(rows_);
    shrink.fast = [=, &x, &moment2, &known](const Kernels<float>& k) {
        w.fast = x;
        beside(k).shrink(moment2.data(), distances, known.data(), kRange, kBound, 9, rows,
                         w.fast.data());
    };
    shrink.plain = [=, &x, &moment2, &known] {
        w.plain = x;
        plain::shrink(moment2.data(), distances, known.data(), kRange, kBound, 9, rows,
                      w.plain.data());
    };
}

}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
#include "mscomp/nn/synthesis.h"

#include <fmt/format.h>

#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/random.h"

namespace mscomp::nn {
namespace {

/// Codes (n,width) of all levels side by side.
std::vector<double> rows_of(const std::vector<std::vector<float>>& levels, std::size_t shapes,
                            std::size_t width) {
    std::vector<double> rows;
    rows.reserve(shapes * width);
    for (std::size_t m = 0; m < shapes; ++m) {
        for (const std::vector<float>& level : levels) {
            const std::size_t of_level = level.size() / shapes;
            for (std::size_t k = 0; k < of_level; ++k) {
                rows.push_back(static_cast<double>(level[m * of_level + k]));
            }
        }
    }
    return rows;
}

/// Takes the mean of each column off and returns it.
std::vector<double> center_rows(std::vector<double>& rows, std::size_t shapes, std::size_t width) {
    std::vector<double> mean(width, 0.0);
    for (std::size_t i = 0; i < rows.size(); ++i) mean[i % width] += rows[i];
    for (double& x : mean) x /= static_cast<double>(shapes);
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] -= mean[i % width];
    return mean;
}

/// Lengths of the columns.
std::vector<double> column_norms(const std::vector<double>& rows, std::size_t width) {
    std::vector<double> norms(width, 0.0);
    for (std::size_t i = 0; i < rows.size(); ++i) norms[i % width] += rows[i] * rows[i];
    for (double& x : norms) x = std::sqrt(x);
    return norms;
}

}  // namespace

Synthesis::Synthesis(const CodeDecoder& decoder, const std::vector<Component>& components,
                     const std::array<double, kFeatureDim>& factor)
    : decoder_(decoder), factor_(factor), reference_(components.size()), end_(components.size()) {
    for (const Component& c : components) {
        reference_[at(c.code)] = static_cast<float>(c.code_reference);
        end_[at(c.code)] = static_cast<float>(c.code_end);
    }
    base_ = decoder.decode(reference_);
}

std::vector<float> Synthesis::codes(std::span<const ComponentWeight> weights) const {
    std::vector<float> codes = reference_;
    for (const ComponentWeight& w : weights) {
        const auto i = at(w.code);
        codes[i] = static_cast<float>(
            std::lerp(static_cast<double>(reference_[i]), static_cast<double>(end_[i]), w.weight));
    }
    return codes;
}

std::vector<float> Synthesis::change(std::span<const float> codes) const {
    return feature_change(decoder_, codes, base_, factor_);
}

CodeSampler::CodeSampler(CodeDistribution distribution,
                         const std::vector<std::vector<float>>& codes, int shapes,
                         std::uint64_t seed)
    : distribution_(distribution), seed_(seed) {
    const auto n = at(shapes);
    for (const std::vector<float>& level : codes) width_ += level.size() / n;
    if (distribution == CodeDistribution::prior) return;
    if (shapes < 2) {
        throw UsageError(fmt::format(
            "a Gaussian cannot be fitted to the codes of {} training shape, wanted at least 2",
            shapes));
    }
    deviations_ = rows_of(codes, n, width_);
    mean_ = center_rows(deviations_, n, width_);
    if (distribution == CodeDistribution::independent) {
        deviations_ = column_norms(deviations_, width_);
    }
    for (double& x : deviations_) x /= std::sqrt(static_cast<double>(n - 1));
}

std::vector<float> CodeSampler::draw(std::uint64_t index) const {
    const CounterRandom random(seed_, index);
    std::vector<float> codes(width_);
    if (distribution_ != CodeDistribution::fitted) {
        const bool prior = distribution_ == CodeDistribution::prior;
        for (std::size_t i = 0; i < width_; ++i) {
            const double w = random.normal(i);
            codes[i] = static_cast<float>(prior ? w : mean_[i] + w * deviations_[i]);
        }
        return codes;
    }
    std::vector<double> sum = mean_;
    for (std::size_t m = 0; m * width_ < deviations_.size(); ++m) {
        const double w = random.normal(m);
        for (std::size_t i = 0; i < width_; ++i) sum[i] += w * deviations_[m * width_ + i];
    }
    for (std::size_t i = 0; i < width_; ++i) codes[i] = static_cast<float>(sum[i]);
    return codes;
}

}  // namespace mscomp::nn

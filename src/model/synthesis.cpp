// SPDX-License-Identifier: MIT
#include "mscomp/model/synthesis.h"

#include <fmt/format.h>

#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/random.h"

namespace mscomp {
namespace {

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

Synthesis::Synthesis(const ShapeModel& model, const std::vector<Component>& components)
    : model_(model), reference_(components.size()), end_(components.size()) {
    for (const Component& c : components) {
        reference_[at(c.code)] = static_cast<float>(c.code_reference);
        end_[at(c.code)] = static_cast<float>(c.code_end);
        Component& moving = moving_.emplace_back();
        moving.code = c.code;
        moving.code_reference = c.code_reference;
        moving.others = c.others;
    }
}

std::vector<float> Synthesis::codes(std::span<const ComponentWeight> weights) const {
    std::vector<float> codes = reference_;
    for (const ComponentWeight& w : weights) {
        const auto i = at(w.code);
        const auto code = static_cast<float>(
            std::lerp(static_cast<double>(reference_[i]), static_cast<double>(end_[i]), w.weight));
        // Whatever others have made of it: one that moves along may have a weight of its own.
        const float by_others = codes[i] - reference_[i];
        put_at(codes, moving_[i], code);
        codes[i] += by_others;
    }
    return codes;
}

std::vector<float> Synthesis::change(std::span<const float> codes) const {
    return model_.change(codes, reference_);
}

CodeSampler::CodeSampler(CodeDistribution distribution, const CodeTable& codes, std::uint64_t seed)
    : distribution_(distribution), seed_(seed), width_(at(codes.code_count)) {
    if (distribution == CodeDistribution::prior) return;
    const auto n = at(codes.shape_count());
    if (n < 2) {
        throw UsageError(fmt::format(
            "a Gaussian cannot be fitted to the codes of {} training shape, wanted at least 2", n));
    }
    deviations_.assign(codes.values.begin(), codes.values.end());
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

}  // namespace mscomp

// SPDX-License-Identifier: MIT
// Group sparsity around centres that follow the component weights, with reaches that are learned.
#include <algorithm>
#include <cmath>

#include "../kernels/spectral_kernels.h"
#include "batch.h"
#include "mscomp/base/index.h"
#include "nn/spectral_ops.h"

namespace mscomp::nn {
namespace {

/// Sum of lengths beyond `range`.
template <class T>
double penalty(std::span<const double> distances, std::span<const T> lengths, double range) {
    return spectral_kernels<T>().outside(distances.data(), lengths.data(), range,
                                         static_cast<int>(lengths.size()));
}

template <class T>
class LearnedSparsity final : public Op<T> {
  public:
    LearnedSparsity(Tape<T>& tape, Var weights, Var ranges, ComponentCenters<T>& centers,
                    StraightThrough straight_through, bool differentiable)
        : weights_(weights),
          ranges_(ranges),
          centers_(centers),
          straight_through_(straight_through),
          differentiable_(differentiable),
          components_(tape.extents(weights)[1]),
          vertices_(tape.extents(weights)[2]),
          channels_(tape.extents(weights)[3]),
          omega_(tape.result("learned_sparsity", {1}, true)),
          outside_(at(components_)) {}

    std::string_view name() const override { return "learned_sparsity"; }
    Var output() const override { return omega_; }

    void forward(Tape<T>& tape) override {
        centers_.focus(tape.value(weights_), static_cast<int>(channels_), tape.value(ranges_));
        parallel_for(components_, [&](std::int64_t k) {
            outside_[at(k)] = penalty(centers_.distances(k), centers_.lengths(k), range(tape, k));
        });
        double sum = 0;
        for (const double x : outside_) sum += x;
        tape.value(omega_)[0] = static_cast<T>(sum / static_cast<double>(components_));
    }

    void backward(Tape<T>& tape) override {
        const double factor =
            static_cast<double>(tape.grad(omega_)[0]) / static_cast<double>(components_);
        parallel_for(components_, [&](std::int64_t k) {
            const auto n = at(k);
            double slope = outside_[n];
            if (straight_through_ == StraightThrough::identity) {
                slope = penalty(centers_.distances(k), centers_.lengths(k), -1.0);
            }
            tape.grad(ranges_)[n] -= static_cast<T>(factor * slope);
            if (differentiable_) add_weight_gradient(tape, k, factor);
        });
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        T omega = 0;
        for (std::int64_t k = 0; k < components_; ++k) {
            for (std::int64_t v = 0; v < vertices_; ++v) {
                if (!is_outside(tape, k, v)) continue;
                T square = 0;
                for (std::int64_t c = 0; c < channels_; ++c) {
                    const T x = tape.value(weights_)[at((k * vertices_ + v) * channels_ + c)];
                    square += x * x;
                }
                omega += std::sqrt(square);
            }
        }
        return {omega / static_cast<T>(components_)};
    }

  private:
    double range(Tape<T>& tape, std::int64_t k) const {
        return static_cast<double>(tape.value(ranges_)[at(k)]);
    }
    bool is_outside(Tape<T>& tape, std::int64_t k, std::int64_t v) const {
        return centers_.distances(k)[at(v)] > range(tape, k);
    }

    void add_weight_gradient(Tape<T>& tape, std::int64_t k, double factor) {
        for (std::int64_t v = 0; v < vertices_; ++v) {
            const T length = centers_.lengths(k)[at(v)];
            if (length == 0 || !is_outside(tape, k, v)) continue;
            const T scale = static_cast<T>(factor / static_cast<double>(length));
            const auto first = at((k * vertices_ + v) * channels_);
            for (std::size_t i = first; i < first + at(channels_); ++i) {
                tape.grad(weights_)[i] += scale * tape.value(weights_)[i];
            }
        }
    }

    Var weights_, ranges_;
    ComponentCenters<T>& centers_;
    StraightThrough straight_through_;
    bool differentiable_;
    std::int64_t components_, vertices_, channels_;
    Var omega_;
    std::vector<double> outside_;  // (K) sum of the lengths outside, last forward pass
};

}  // namespace

template <class T>
void ComponentCenters<T>::focus(std::span<const T> component_weights, int channels,
                                std::span<const T> ranges) {
    const auto vertices = at(distances_.vertex_count());
    const std::size_t count = ranges.size();
    lengths_.resize(count * vertices);
    std::vector<int> longest(count);
    parallel_for(static_cast<std::int64_t>(count), [&](std::int64_t index) {
        const std::size_t first = at(index) * vertices;
        longest[at(index)] =
            spectral_kernels<T>().lengths(component_weights.data() + first * at(channels), channels,
                                          static_cast<int>(vertices), lengths_.data() + first);
    });
    centers_.resize(count, -1);
    rows_.resize(count);
    distances_.prepare(longest);
    std::vector<std::span<const double>> candidates(count);
    for (std::size_t k = 0; k < count; ++k) {
        if (rule_ == CenterRule::follow || centers_[k] < 0) centers_[k] = longest[k];
        rows_[k] = distances_.row(centers_[k]);
        candidates[k] = distances_.row(longest[k]);
    }
    parallel_for(static_cast<std::int64_t>(count), [&](std::int64_t index) {
        const auto k = at(index);
        if (centers_[k] == longest[k]) return;
        const auto range = static_cast<double>(ranges[k]);
        if (penalty(candidates[k], lengths(index), range) <
            penalty(rows_[k], lengths(index), range)) {
            centers_[k] = longest[k];
            rows_[k] = candidates[k];
        }
    });
}

template <class T>
std::span<const T> ComponentCenters<T>::lengths(std::int64_t k) const {
    const auto size = at(distances_.vertex_count());
    return std::span<const T>(lengths_).subspan(at(k) * size, size);
}

template <class T>
Var learned_sparsity(Tape<T>& tape, Var component_weights, Var ranges, ComponentCenters<T>& centers,
                     StraightThrough straight_through, bool differentiable) {
    return record_op<LearnedSparsity<T>>(tape, component_weights, ranges, centers, straight_through,
                                         differentiable);
}

template class ComponentCenters<float>;
template class ComponentCenters<double>;
template Var learned_sparsity(Tape<float>&, Var, Var, ComponentCenters<float>&, StraightThrough,
                              bool);
template Var learned_sparsity(Tape<double>&, Var, Var, ComponentCenters<double>&, StraightThrough,
                              bool);

}  // namespace mscomp::nn

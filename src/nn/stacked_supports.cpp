// SPDX-License-Identifier: MIT
// Which vertices the last level touches.
#include <algorithm>
#include <cassert>
#include <cmath>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/parallel.h"
#include "mscomp/nn/optimizer.h"
#include "mscomp/nn/stacked_model.h"
#include "ops/autoencoder.h"
#include "ops/batch.h"

namespace mscomp::nn {
namespace {

std::size_t at(std::int64_t index) { return static_cast<std::size_t>(index); }

template <class T>
double length_of(std::span<const T> nine) {
    double square = 0;
    for (const T x : nine) square += static_cast<double>(x) * static_cast<double>(x);
    return std::sqrt(square);
}

/// Length of the gradient of component k at a packed row.
template <class T>
double length_at(const T* packed, int padded, int k) {
    double square = 0;
    for (int c = 0; c < kFeatureDim; ++c) {
        const auto g = static_cast<double>(packed[c * padded + k]);
        square += g * g;
    }
    return std::sqrt(square);
}

}  // namespace

template <class T>
bool StackedModel<T>::has_supports() const {
    return options_.supports && !fused_.empty() && !options_.sparsity_gradient;
}

template <class T>
std::vector<std::uint8_t> StackedModel<T>::inner_acting(int level) const {
    const LevelSupports& supports = *levels_[at(level)].supports;
    std::vector<std::uint8_t> acts(at(std::int64_t{supports.count()} * vertex_count()), 0);
    for (int a = 0; a < supports.count(); ++a) {
        for (const int v : supports.of(a).acting_vertices) {
            acts[at(std::int64_t{a} * vertex_count() + v)] = 1;
        }
    }
    return acts;
}

template <class T>
std::vector<std::uint8_t> StackedModel<T>::acting(int level) const {
    const std::vector<std::uint8_t> inner = inner_acting(level);
    std::vector<std::uint8_t> user(inner.size());
    for (std::size_t i = 0; i < inner.size(); ++i) {
        const std::size_t v = i % at(vertex_count());
        user[i - v + at(order_.to_user[v])] = inner[i];
    }
    return user;
}

template <class T>
void StackedModel<T>::set_acting(int level, std::span<const std::uint8_t> user) {
    std::vector<std::uint8_t> inner(user.size());
    for (std::size_t i = 0; i < inner.size(); ++i) {
        const std::size_t v = i % at(vertex_count());
        inner[i] = user[i - v + at(order_.to_user[v])];
    }
    set_inner_acting(level, inner);
}

template <class T>
void StackedModel<T>::set_inner_acting(int level, std::span<const std::uint8_t> acts) {
    const Level& l = levels_[at(level)];
    l.supports->set(acts);
    std::vector<typename ParameterSet<T>::Range> live;
    for (int a = 0; a < l.autoencoders; ++a) {
        const std::vector<int>& vertices = l.supports->of(a).acting_vertices;
        for (int k = 0; k < l.components; ++k) {
            const std::int64_t row = (std::int64_t{a} * l.components + k) * vertex_count();
            for (std::size_t first = 0; first < vertices.size();) {
                std::size_t last = first + 1;
                while (last < vertices.size() && vertices[last] == vertices[last - 1] + 1) ++last;
                live.push_back({(row + vertices[first]) * kFeatureDim,
                                (row + vertices[last - 1] + 1) * kFeatureDim});
                first = last;
            }
        }
    }
    parameters_.set_live(l.weights, std::move(live));
}

template <class T>
void StackedModel<T>::act_where_weights_are() {
    const int level = static_cast<int>(levels_.size()) - 1;
    const Level& l = levels_.back();
    const std::span<const T> weights = parameters_.value(l.weights);
    std::vector<std::uint8_t> acts(at(std::int64_t{l.autoencoders} * vertex_count()), 0);
    for_each_chunk(l.autoencoders, vertex_count(), [&](std::int64_t a, std::int64_t, int b, int e) {
        for (int k = 0; k < l.components; ++k) {
            const std::int64_t row = (a * l.components + k) * vertex_count();
            for (int v = b; v < e; ++v) {
                const auto c = weights.subspan(at((row + v) * kFeatureDim), kFeatureDim);
                if (std::ranges::any_of(c, [](T x) { return x != 0; })) {
                    acts[at(a * vertex_count() + v)] = 1;
                }
            }
        }
    });
    set_inner_acting(level, acts);
}

template <class T>
double StackedModel<T>::touched(int level) const {
    const LevelSupports& supports = *levels_[at(level)].supports;
    double sum = 0;
    for (int a = 0; a < supports.count(); ++a) sum += supports.of(a).slot_count();
    return sum / (static_cast<double>(supports.count()) * vertex_count());
}

template <class T>
typename StackedModel<T>::SupportChange StackedModel<T>::adapt_supports(double sparsity_weight,
                                                                        std::int64_t step) {
    assert(has_supports());
    const int index = static_cast<int>(levels_.size()) - 1;
    const Level& level = levels_.back();
    const Autoencoder<T>& op = *fused_.back();
    const int components = level.components, padded = op.padded_components();
    const std::int64_t vertices = vertex_count();
    const std::vector<SparsityRow>& around =
        level.sparsity->focus(std::span<const T>(parameters_.value(level.weights)));
    const std::vector<std::uint8_t> before = inner_acting(index);
    std::vector<std::uint8_t> acts = before;
    const std::span<T> weights = parameters_.value(level.weights);
    const std::span<T> moment2 = parameters_.moment2(level.weights);
    const double correction = second_moment_correction(step);
    std::vector<double> curvature(at(components));
    AlignedVector<T> grads;
    // Moments of admitted vertices, to be written once these are live.
    struct Moment {
        std::int64_t at;
        T value;
    };
    std::vector<std::vector<Moment>> moments(at(chunk_count(vertices)));
    std::vector<Moment> admitted;
    for (int a = 0; a < level.autoencoders; ++a) {
        op.full_component_grads(tape_, a, grads);
        const double error_weight = static_cast<double>(tape_.grad(level.reconstruction)[at(a)]);
        const double worthwhile = kWorthwhile * error_weight *
                                  static_cast<double>(tape_.value(level.reconstruction)[at(a)]) /
                                  static_cast<double>(vertices);
        for (int k = 0; k < components; ++k) {
            const auto lanes = static_cast<std::int64_t>(lane_mask_.weight.size());
            double squares = 0;
            for (int m = 0; m < lane_mask_.active; ++m) {
                const auto code = static_cast<double>(
                    tape_.value(level.code)[at((std::int64_t{a} * components + k) * lanes + m)]);
                squares += code * code;
            }
            curvature[at(k)] = 2 * error_weight * squares / lane_mask_.active;
        }
        for_each_chunk(1, vertices, [&](std::int64_t, std::int64_t chunk, int b, int e) {
            moments[at(chunk)].clear();
            for (int v = b; v < e; ++v) {
                std::uint8_t& acts_here = acts[at(a * vertices + v)];
                const T* packed = grads.data() + std::int64_t{v} * kFeatureDim * padded;
                double gain = 0, cost = 0;  // of admitting the vertex, of leaving it out
                for (int k = 0; k < components; ++k) {
                    const std::int64_t row = std::int64_t{a} * components + k;
                    const double length = length_of<T>(
                        weights.subspan(at((row * vertices + v) * kFeatureDim), kFeatureDim));
                    const double grad = length_at(packed, padded, k);
                    cost += length * (grad + curvature[at(k)] * length / 2);
                    const double slope =
                        grad - sparsity_weight * around[at(row)].weight(v) / components;
                    if (length == 0 && slope > 0 && curvature[at(k)] > 0) {
                        gain += slope * slope / (2 * curvature[at(k)]);
                    }
                }
                if (acts_here != 0) {
                    if (gain + cost < 0.25 * worthwhile) acts_here = 0;
                    continue;
                }
                if (!(gain > worthwhile)) continue;
                acts_here = 1;
                for (int k = 0; k < components; ++k) {
                    const std::int64_t row = std::int64_t{a} * components + k;
                    for (int c = 0; c < kFeatureDim; ++c) {
                        const T g = packed[c * padded + k];
                        moments[at(chunk)].push_back({(row * vertices + v) * kFeatureDim + c,
                                                      g * g * static_cast<T>(correction)});
                    }
                }
            }
        });
        for (const auto& each : moments) admitted.insert(admitted.end(), each.begin(), each.end());
    }
    SupportChange change;
    for (std::size_t i = 0; i < acts.size(); ++i) {
        change.admitted += acts[i] > before[i] ? 1 : 0;
        change.dropped += acts[i] < before[i] ? 1 : 0;
    }
    if (change.admitted + change.dropped == 0) return change;
    for (std::size_t i = 0; i < acts.size(); ++i) {
        if (acts[i] >= before[i]) continue;
        const std::int64_t a = static_cast<std::int64_t>(i) / vertices;
        const std::int64_t v = static_cast<std::int64_t>(i) % vertices;
        for (int k = 0; k < components; ++k) {
            const std::int64_t row = a * components + k;
            std::fill_n(weights.begin() + (row * vertices + v) * kFeatureDim, kFeatureDim, T{0});
        }
    }
    set_inner_acting(index, acts);
    for (const Moment& moment : admitted) moment2[at(moment.at)] = moment.value;
    return change;
}

template bool StackedModel<float>::has_supports() const;
template bool StackedModel<double>::has_supports() const;
template std::vector<std::uint8_t> StackedModel<float>::acting(int) const;
template std::vector<std::uint8_t> StackedModel<double>::acting(int) const;
template void StackedModel<float>::set_acting(int, std::span<const std::uint8_t>);
template void StackedModel<double>::set_acting(int, std::span<const std::uint8_t>);
template void StackedModel<float>::act_where_weights_are();
template void StackedModel<double>::act_where_weights_are();
template double StackedModel<float>::touched(int) const;
template double StackedModel<double>::touched(int) const;
template StackedModel<float>::SupportChange StackedModel<float>::adapt_supports(double,
                                                                                std::int64_t);
template StackedModel<double>::SupportChange StackedModel<double>::adapt_supports(double,
                                                                                  std::int64_t);

}  // namespace mscomp::nn

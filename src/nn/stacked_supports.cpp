// SPDX-License-Identifier: MIT
// Which vertices the last level touches.
#include <algorithm>
#include <cassert>
#include <cmath>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "nn/optimizer.h"
#include "nn/stacked_model.h"
#include "ops/autoencoder.h"
#include "ops/batch.h"

namespace mscomp::nn {
namespace {

template <class T>
bool all_zero(std::span<const T> values) {
    return std::ranges::all_of(values, [](T x) { return x == 0; });
}

/// Gradients of the component weights of one autoencoder, (V,9,padded).
template <class T>
struct PackedGrads {
    const T* values;
    int padded;

    T at(int vertex, int channel, int k) const {
        return values[(std::int64_t{vertex} * kFeatureDim + channel) * padded + k];
    }
    double length(int vertex, int k) const {
        double square = 0;
        for (int c = 0; c < kFeatureDim; ++c) {
            const auto g = static_cast<double>(at(vertex, c, k));
            square += g * g;
        }
        return std::sqrt(square);
    }
};

/// The second moment that an entry of the component weights starts with.
template <class T>
struct Admitted {
    std::int64_t at;
    T moment2;
};

}  // namespace

template <class T>
bool StackedModel<T>::has_supports() const {
    return options_.supports && !fused_.empty() && !options_.sparsity_gradient;
}

template <class T>
std::vector<std::uint8_t> StackedModel<T>::inner_acting(int level) const {
    const LevelSupports& supports = *levels_[at(level)].supports;
    std::vector<std::uint8_t> acts(at(std::int64_t{supports.count()} * this->vertex_count()), 0);
    for (int a = 0; a < supports.count(); ++a) {
        for (const int v : supports.of(a).acting_vertices) {
            acts[at(std::int64_t{a} * this->vertex_count() + v)] = 1;
        }
    }
    return acts;
}

template <class T>
std::vector<std::uint8_t> StackedModel<T>::acting(int level) const {
    const std::vector<std::uint8_t> inner = inner_acting(level);
    std::vector<std::uint8_t> user(inner.size());
    for (std::size_t i = 0; i < inner.size(); ++i) {
        const std::size_t v = i % at(this->vertex_count());
        user[i - v + at(order_.to_user[v])] = inner[i];
    }
    return user;
}

template <class T>
void StackedModel<T>::set_acting(int level, std::span<const std::uint8_t> user) {
    std::vector<std::uint8_t> inner(user.size());
    for (std::size_t i = 0; i < inner.size(); ++i) {
        const std::size_t v = i % at(this->vertex_count());
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
            const std::int64_t row = (std::int64_t{a} * l.components + k) * this->vertex_count();
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
std::vector<std::uint8_t> StackedModel<T>::acting_by_weights() const {
    const Level& l = levels_.back();
    const std::span<const T> weights = parameters_.value(l.weights);
    std::vector<std::uint8_t> acts(at(std::int64_t{l.autoencoders} * this->vertex_count()), 0);
    for_each_chunk(
        l.autoencoders, this->vertex_count(), [&](std::int64_t a, std::int64_t, int b, int e) {
            for (int k = 0; k < l.components; ++k) {
                const std::int64_t row = (a * l.components + k) * this->vertex_count();
                for (int v = b; v < e; ++v) {
                    const auto c = weights.subspan(at((row + v) * kFeatureDim), kFeatureDim);
                    if (!all_zero<T>(c)) acts[at(a * this->vertex_count() + v)] = 1;
                }
            }
        });
    return acts;
}

template <class T>
void StackedModel<T>::act_where_weights_are() {
    set_inner_acting(static_cast<int>(levels_.size()) - 1, acting_by_weights());
}

template <class T>
double StackedModel<T>::touched(int level) const {
    const LevelSupports& supports = *levels_[at(level)].supports;
    double sum = 0;
    for (int a = 0; a < supports.count(); ++a) sum += supports.of(a).slot_count();
    return sum / (static_cast<double>(supports.count()) * this->vertex_count());
}

template <class T>
std::vector<double> StackedModel<T>::curvatures(int autoencoder) {
    const Level& level = levels_.back();
    const auto lanes = static_cast<std::int64_t>(lane_mask_.weight.size());
    const auto weight = static_cast<double>(
        level.sum_error.valid() ? tape_.grad(level.sum_error)[0]
                                : tape_.grad(level.reconstruction)[at(autoencoder)]);
    std::vector<double> curvatures(at(level.components));
    for (int k = 0; k < level.components; ++k) {
        const std::int64_t row = std::int64_t{autoencoder} * level.components + k;
        double squares = 0;
        for (int m = 0; m < lane_mask_.active; ++m) {
            const auto code = static_cast<double>(tape_.value(level.code)[at(row * lanes + m)]);
            squares += code * code;
        }
        curvatures[at(k)] = 2 * weight * squares / lane_mask_.active;
    }
    return curvatures;
}

/// What a vertex has to gain to be admitted to an autoencoder of the last level.
template <class T>
double StackedModel<T>::worthwhile(int autoencoder) {
    const Level& level = levels_.back();
    const bool is_sum = level.sum_error.valid();
    const Var error = is_sum ? level.sum_error : level.reconstruction;
    const std::size_t which = is_sum ? 0 : at(autoencoder);
    const double whole = static_cast<double>(tape_.grad(error)[which]) *
                         static_cast<double>(tape_.value(error)[which]);
    return kWorthwhile * whole / (this->vertex_count() * (is_sum ? level.autoencoders : 1.0));
}

template <class T>
typename StackedModel<T>::SupportChange StackedModel<T>::adapt_supports(double sparsity_weight,
                                                                        std::int64_t step) {
    assert(has_supports());
    const Level& level = levels_.back();
    const Autoencoder<T>& op = *fused_.back();
    const int index = static_cast<int>(levels_.size()) - 1, components = level.components;
    const std::int64_t vertices = this->vertex_count(), nine = kFeatureDim;
    const std::span<const T> weights = parameters_.value(level.weights);
    const std::vector<SparsityRow>& around = level.sparsity->focus(weights);
    const double correction = second_moment_correction(step);
    const std::vector<std::uint8_t> before = inner_acting(index);
    std::vector<std::uint8_t> acts = before;
    std::vector<std::vector<Admitted<T>>> admitted(at(level.autoencoders * chunk_count(vertices)));
    AlignedVector<T> grads;
    for (int a = 0; a < level.autoencoders; ++a) {
        op.full_component_grads(tape_, a, grads);
        const std::vector<double> curvature = curvatures(a);
        const double least_gain = worthwhile(a);
        const PackedGrads<T> packed{grads.data(), op.padded_components()};
        for_each_chunk(1, vertices, [&](std::int64_t, std::int64_t chunk, int b, int e) {
            for (int v = b; v < e; ++v) {
                std::uint8_t& acts_here = acts[at(a * vertices + v)];
                double gain = 0;
                bool is_zero = true;
                for (int k = 0; k < components; ++k) {
                    const std::int64_t row = std::int64_t{a} * components + k;
                    is_zero = is_zero && all_zero<T>(weights.subspan(
                                             at((row * vertices + v) * nine), at(nine)));
                    const double slope = packed.length(v, k) -
                                         sparsity_weight * around[at(row)].weight(v) / components;
                    if (slope > 0 && curvature[at(k)] > 0) {
                        gain += slope * slope / (2 * curvature[at(k)]);
                    }
                }
                if (acts_here != 0) {
                    if (is_zero && !(gain >= 0.25 * least_gain)) acts_here = 0;
                    continue;
                }
                if (!(gain > least_gain)) continue;
                acts_here = 1;
                for (int k = 0; k < components; ++k) {
                    const std::int64_t row = std::int64_t{a} * components + k;
                    for (int c = 0; c < kFeatureDim; ++c) {
                        const auto g = static_cast<double>(packed.at(v, c, k));
                        admitted[at(a * chunk_count(vertices) + chunk)].push_back(
                            {(row * vertices + v) * nine + c, static_cast<T>(g * g * correction)});
                    }
                }
            }
        });
    }
    SupportChange change;
    for (std::size_t i = 0; i < acts.size(); ++i) {
        change.admitted += acts[i] > before[i] ? 1 : 0;
        change.dropped += acts[i] < before[i] ? 1 : 0;
    }
    if (change.admitted + change.dropped == 0) return change;
    set_inner_acting(index, acts);
    const std::span<T> moment2 = parameters_.moment2(level.weights);
    for (const auto& of_chunk : admitted) {
        for (const Admitted<T>& entry : of_chunk) moment2[at(entry.at)] = entry.moment2;
    }
    return change;
}

template <class T>
std::vector<std::uint8_t> StackedModel<T>::acting_vertices() const {
    if (!has_supports()) return {};
    return acting(static_cast<int>(levels_.size()) - 1);
}

template <class T>
bool StackedModel<T>::restore_acting_vertices(std::span<const std::uint8_t> acting) {
    if (!has_supports()) return true;
    if (acting.empty()) {
        act_where_weights_are();
        return true;
    }
    // Some act with weights of zero: their moments must not stop being live in between.
    const std::vector<std::uint8_t> needed = acting_by_weights();
    for (std::size_t i = 0; i < needed.size(); ++i) {
        const std::size_t v = i % at(this->vertex_count());
        if (needed[i] > acting[i - v + at(order_.to_user[v])]) return false;
    }
    set_acting(static_cast<int>(levels_.size()) - 1, acting);
    return true;
}

template bool StackedModel<float>::has_supports() const;
template bool StackedModel<double>::has_supports() const;
template std::vector<std::uint8_t> StackedModel<float>::acting(int) const;
template std::vector<std::uint8_t> StackedModel<double>::acting(int) const;
template void StackedModel<float>::set_acting(int, std::span<const std::uint8_t>);
template void StackedModel<double>::set_acting(int, std::span<const std::uint8_t>);
template std::vector<std::uint8_t> StackedModel<float>::acting_vertices() const;
template std::vector<std::uint8_t> StackedModel<double>::acting_vertices() const;
template bool StackedModel<float>::restore_acting_vertices(std::span<const std::uint8_t>);
template bool StackedModel<double>::restore_acting_vertices(std::span<const std::uint8_t>);
template void StackedModel<float>::act_where_weights_are();
template void StackedModel<double>::act_where_weights_are();
template double StackedModel<float>::touched(int) const;
template double StackedModel<double>::touched(int) const;
template StackedModel<float>::SupportChange StackedModel<float>::adapt_supports(double,
                                                                                std::int64_t);
template StackedModel<double>::SupportChange StackedModel<double>::adapt_supports(double,
                                                                                  std::int64_t);

}  // namespace mscomp::nn

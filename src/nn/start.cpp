// SPDX-License-Identifier: MIT
#include "nn/start.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "learning/deflation.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "nn/dim.h"
#include "nn/start_shapes.h"

namespace mscomp::nn {
namespace {

template <class T>
void set_identity(std::span<T> matrices) {
    for (std::size_t i = 0; i < matrices.size(); ++i) {
        const std::size_t entry = i % (kDim * kDim);
        matrices[i] = entry / kDim == entry % kDim ? T{1} : T{0};
    }
}

/// `rows` (V,9,lanes) is there to work in.
template <class T>
DeflationResidual residual_of(StackedModel<T>& model, int level, std::int64_t a,
                              const StartShapes& start, std::span<T> rows) {
    const std::int64_t lanes = lane_count(model.batch_capacity());
    DeflationResidual residual(model.vertex_count(), start.count());
    for (std::size_t first = 0; first < start.shapes.size(); first += start.batch) {
        // One pass holds them all: it has been made already.
        if (start.batch < start.shapes.size()) {
            model.load_batch(start.features, start.pass(first));
            model.forward();
        }
        model.input_rows(level, static_cast<int>(a), rows);
        residual.fill(rows.data(), lanes, static_cast<std::int64_t>(first),
                      static_cast<std::int64_t>(start.pass(first).size()), squashed);
    }
    residual.drop_silent_vertices();
    return residual;
}

template <class T>
void deflate_level(StackedModel<T>& model, int index, const StartShapes& start,
                   std::span<const int> candidates) {
    const auto& level = model.levels()[at(index)];
    const std::int64_t size = model.vertex_count() * kDim;
    const std::span<T> weights = model.parameters().value(level.weights);
    AlignedVector<T> rows(at(size * lane_count(model.batch_capacity())));
    const auto free_places = [&](int center, std::span<const int> vertices) {
        const SparsityRow around = level.sparsity->row(center);
        std::vector<int> places;
        for (std::size_t n = 0; n < vertices.size(); ++n) {
            if (around.is_free(vertices[n])) places.push_back(static_cast<int>(n));
        }
        return places;
    };
    std::vector<int> centers;
    for (std::int64_t a = 0; a < level.autoencoders; ++a) {
        DeflationResidual residual = residual_of(model, index, a, start, std::span<T>(rows));
        const auto found =
            deflate(residual, level.components, model.inner_distances(), free_places, candidates);
        for (std::size_t k = 0; k < found.size(); ++k) {
            centers.push_back(found[k].center);
            const std::int64_t row = a * level.components + static_cast<std::int64_t>(k);
            write_direction(residual, found[k].direction, kDim,
                            weights.subspan(at(row * size), at(size)));
        }
    }
    level.sparsity->set_centers(std::move(centers));
}

}  // namespace

template <class T>
void start_random(StackedModel<T>& model, std::uint64_t seed) {
    constexpr double kDeviation = 0.02;
    ParameterSet<T>& parameters = model.parameters();
    for (const auto& level : model.levels()) {
        level.sparsity->set_centers({});
        for (const int index : {level.w_own, level.w_ring, level.decoder_w_own,
                                level.decoder_w_ring, level.weights}) {
            const CounterRandom random(seed, static_cast<std::uint64_t>(index) + 1);
            std::vector<T> drawn(parameters.value(index).size());
            for (std::size_t i = 0; i < drawn.size(); ++i) {
                drawn[i] = static_cast<T>(kDeviation * random.normal(i));
            }
            model.from_user_order(index, drawn, parameters.value(index));
        }
        for (const int index : {level.bias, level.decoder_bias}) {
            std::ranges::fill(parameters.value(index), T{0});
        }
    }
    if (model.has_supports()) model.act_where_weights_are();
}

template <class T>
void start_deflation(StackedModel<T>& model, const ScaledFeatures& features,
                     std::span<const int> shapes) {
    ParameterSet<T>& parameters = model.parameters();
    parameters.reset_values();
    for (const auto& level : model.levels()) {
        set_identity(parameters.value(level.w_own));
        set_identity(parameters.value(level.decoder_w_own));
    }
    const StartShapes start(features, shapes, model.batch_capacity());
    const std::vector<int> candidates = spread_vertices(model.inner_distances(), kCandidates);
    // Levels that have not been started need not be touched.
    if (model.has_supports()) model.act_where_weights_are();
    model.load_batch(features, start.pass(0));
    for (int level = 0; level < static_cast<int>(model.levels().size()); ++level) {
        model.forward();
        deflate_level(model, level, start, candidates);
    }
    if (model.has_supports()) model.act_where_weights_are();
}

template void start_random(StackedModel<float>&, std::uint64_t);
template void start_random(StackedModel<double>&, std::uint64_t);
template void start_deflation(StackedModel<float>&, const ScaledFeatures&, std::span<const int>);
template void start_deflation(StackedModel<double>&, const ScaledFeatures&, std::span<const int>);

}  // namespace mscomp::nn

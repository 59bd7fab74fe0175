// SPDX-License-Identifier: MIT
#include "op_table.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "gradient_check.h"
#include "shapes.h"

namespace mscomp::nn {
namespace {

constexpr int kAutoencoders = 2, kComponentsEach = 3;

template <class T>
std::int64_t vertices(const OpFixture<T>& f) {
    return f.rings->vertex_count();
}

template <class T>
std::int64_t lanes(const OpFixture<T>& f) {
    return static_cast<std::int64_t>(f.lanes.weight.size());
}

template <class T>
Var random_input(OpFixture<T>& f, const char* name, Extents extents, double scale = 1.0) {
    const Var var = f.tape.input(name, std::move(extents), true);
    fill_random(f.tape, var, static_cast<std::uint64_t>(var.index), scale);
    f.inputs.push_back(var);
    return var;
}

template <class T>
Var rows(OpFixture<T>& f, const char* name, std::int64_t autoencoders = kAutoencoders) {
    return random_input(f, name, {autoencoders, vertices(f), 9, lanes(f)});
}

template <class T>
Var weights(OpFixture<T>& f, double scale = 0.3) {
    return random_input(f, "C", {kAutoencoders, kComponentsEach, vertices(f), 9}, scale);
}

template <class T>
Var codes(OpFixture<T>& f, double scale = 1.0) {
    return random_input(f, "codes", {kAutoencoders, kComponentsEach, lanes(f)}, scale);
}

template <class T>
void conv(OpFixture<T>& f, bool transposed, Activation activation) {
    const Var x = rows(f, "x");
    const Var own = random_input(f, "w_own", {kAutoencoders, 9, 9}, 0.2);
    const Var ring = random_input(f, "w_ring", {kAutoencoders, 9, 9}, 0.2);
    const Var bias = random_input(f, "bias", {kAutoencoders, 9}, 0.2);
    f.output = mesh_conv(f.tape, *f.rings, x, own, ring, bias, transposed, activation);
}

/// Component weights whose largest vertex is clear, so that no centre flips under a small step.
template <class T>
Var weights_with_centers(OpFixture<T>& f) {
    const Var c = weights(f);
    for (int row = 0; row < kAutoencoders * kComponentsEach; ++row) {
        const std::int64_t v = (5 * row + 3) % vertices(f);
        f.tape.value(c)[static_cast<std::size_t>((row * vertices(f) + v) * 9)] = T{4};
    }
    return c;
}

template <class T>
Var sparsity(OpFixture<T>& f, Var weights, const LevelConfig& level) {
    f.sparsity = std::make_unique<SparsityRows>(*f.distances, level, CenterRule::follow);
    return group_sparsity(f.tape, weights, *f.sparsity, true);
}

/// A level of two parents with two children each, or of two autoencoders that keep their residuals.
template <class T>
void fused_level(OpFixture<T>& f, bool has_children) {
    const std::int64_t count = has_children ? kAutoencoders : 2 * kAutoencoders;
    AutoencoderInputs level;
    level.source = rows(f, "source");
    if (!has_children) level.mask = random_input(f, "mask", {count, vertices(f)}, 0.5);
    level.w_own = random_input(f, "w_own", {count, 9, 9}, 0.2);
    level.w_ring = random_input(f, "w_ring", {count, 9, 9}, 0.2);
    level.bias = random_input(f, "bias", {count, 9}, 0.2);
    level.decoder_w_own = level.w_own;
    level.decoder_w_ring = level.w_ring;
    level.decoder_bias = random_input(f, "decoder_bias", {count, 9}, 0.2);
    level.component_weights = random_input(f, "C", {count, kComponentsEach, vertices(f), 9}, 0.1);
    level.keeps_residual = has_children;
    level.keeps_sum_error = true;
    f.supports = std::make_unique<LevelSupports>(f.rings->rings, static_cast<int>(count));
    const AutoencoderOutputs outputs = autoencoder(f.tape, *f.rings, level, f.lanes, *f.supports);
    f.output = outputs.error;
    f.further_outputs.push_back(outputs.code);
    f.further_outputs.push_back(outputs.sum_error);
    if (has_children) f.further_outputs.push_back(outputs.residual);
}

}  // namespace

LineDistances::LineDistances(int vertices) {
    for (int i = 0; i < vertices; ++i) {
        std::vector<double>& row = rows_.emplace_back();
        for (int j = 0; j < vertices; ++j) row.push_back(std::abs(i - j) / (vertices - 1.0));
    }
}

template <class T>
std::vector<OpCase<T>> stacked_op_table() {
    using F = OpFixture<T>;
    return {
        {"mesh_conv tanh", [](F& f) { conv(f, false, Activation::tanh); }},
        {"mesh_conv linear transposed", [](F& f) { conv(f, true, Activation::none); }},
        {"project",
         [](F& f) {
             const Var x = rows(f, "rows");
             f.output = project(f.tape, x, weights(f));
         }},
        {"expand",
         [](F& f) {
             const Var z = codes(f);
             f.output = expand(f.tape, z, weights(f));
         }},
        {"tanh", [](F& f) { f.output = tanh(f.tape, codes(f)); }},
        {"tanh of rows", [](F& f) { f.output = tanh(f.tape, rows(f, "x")); }},
        {"attention_mask", [](F& f) { f.output = attention_mask(f.tape, weights(f), 1.0, 1e-3); }},
        {"attention_mask sharpened",
         [](F& f) { f.output = attention_mask(f.tape, weights(f), 3.0, 1e-3); }},
        {"masked_residual",
         [](F& f) {
             const Var x = rows(f, "x"), y = rows(f, "y");
             const Var mask =
                 random_input(f, "mask", {kAutoencoders * kComponentsEach, vertices(f)});
             f.output = masked_residual(f.tape, x, y, mask, true);
         }},
        {"masked_residual without mask",
         [](F& f) {
             const Var x = rows(f, "x"), y = rows(f, "y");
             f.output = masked_residual(f.tape, x, y, Var{}, true);
         }},
        {"sum_rows",
         [](F& f) {
             const Var x = rows(f, "x"), y = rows(f, "y", 1);
             f.output = sum_rows(f.tape, {x, y}, true);
         }},
        {"squared_error",
         [](F& f) {
             const Var x = rows(f, "x"), y = rows(f, "y");
             f.output = squared_error(f.tape, x, y, f.lanes);
         }},
        {"group_sparsity step",
         [](F& f) {
             const Var c = weights_with_centers(f);
             f.output = sparsity(f, c, {3, 0.4, 1.0, {}});
         }},
        {"group_sparsity ramp",
         [](F& f) {
             const Var c = weights_with_centers(f);
             f.output = sparsity(f, c, {3, 0.4, {}, SparsityRamp{0.2, 0.5}});
         }},
        {"range_penalty",
         [](F& f) { f.output = range_penalty(f.tape, codes(f, 2.0), 1.0, f.lanes); }},
        {"autoencoder", [](F& f) { fused_level(f, false); }},
        {"autoencoder with children", [](F& f) { fused_level(f, true); }},
        {"weighted_sum",
         [](F& f) {
             const Var a = random_input(f, "a", {3}), b = random_input(f, "b", {2});
             f.output = weighted_sum(f.tape, {a, b}, {2.0, -0.5});
         }},
    };
}

template <class T>
std::vector<OpCase<T>> op_table() {
    std::vector<OpCase<T>> table = stacked_op_table<T>();
    std::ranges::copy(spectral_op_table<T>(), std::back_inserter(table));
    return table;
}

template <class T>
std::unique_ptr<OpFixture<T>> make_fixture(const OpCase<T>& op_case, FixtureSize size) {
    const bool wide = size == FixtureSize::wide;
    auto fixture = std::make_unique<OpFixture<T>>();
    TriangleMesh mesh = wide ? shapes::grid(17, 17) : shapes::grid(4, 3);
    mesh.vertices.push_back({9, 9, 9});  // in no face: its ring is empty
    fixture->rings =
        std::make_unique<RingTable<T>>(one_rings_of_faces(mesh.vertex_count(), mesh.faces));
    fixture->laplacian = std::make_unique<ScaledLaplacian<T>>(
        fixture->rings->rings, std::span<const double>{}, LambdaMax::exact);
    fixture->distances = std::make_unique<LineDistances>(mesh.vertex_count());
    fixture->lanes.active = wide ? 37 : 5;
    fixture->lanes.weight.assign(wide ? 48 : 8, T{0});
    std::fill_n(fixture->lanes.weight.begin(), fixture->lanes.active, T{1});
    op_case.build(*fixture);
    return fixture;
}

template std::vector<OpCase<float>> op_table();
template std::vector<OpCase<double>> op_table();
template std::unique_ptr<OpFixture<float>> make_fixture(const OpCase<float>&, FixtureSize);
template std::unique_ptr<OpFixture<double>> make_fixture(const OpCase<double>&, FixtureSize);

}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
// The fused op against the small ops that it stands for.
#include "nn/ops/autoencoder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "gradient_check.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "nn/fused.h"
#include "shapes.h"

namespace mscomp::nn {
namespace {

constexpr int kParents = 2, kChildren = 3, kComponents = 5;

struct Reading {
    std::string name;
    bool is_masked = true;
    bool is_partial = false;
    bool keeps_residual = false;
    bool has_own_decoder = false;
    Activation latent = Activation::none;
    int components = kComponents;
    bool joint = true;
    bool keeps_sum_error = false;
    friend void PrintTo(const Reading& reading, std::ostream* out) { *out << reading.name; }
};

Reading with_sum(Reading reading) {
    reading.keeps_sum_error = true;
    return reading;
}

/// One level on random inputs, fused or made of small ops.
template <class T>
struct LevelFixture {
    RingTable<T> rings;
    LaneMask<T> lanes;
    std::unique_ptr<LevelSupports> supports;
    std::vector<std::uint8_t> acts;  // (A,V)
    Tape<T> tape;
    std::vector<Var> inputs;
    AutoencoderInputs level;
    AutoencoderOutputs outputs;
    bool forgets_outside = true;
    bool expects_backward = false;
    double error_grad = 0;  // random ones where it is 0

    int autoencoders(const Reading& reading) const {
        return reading.is_masked ? kParents * kChildren : kParents;
    }

    LevelFixture(const TriangleMesh& mesh, const Reading& reading, bool is_fused)
        : rings(one_rings_of_faces(mesh.vertex_count(), mesh.faces)) {
        constexpr int kLanes = 16;
        lanes.active = 11;
        lanes.weight.assign(kLanes, T{0});
        std::fill_n(lanes.weight.begin(), lanes.active, T{1});
        const std::int64_t vertices = mesh.vertex_count();
        const std::int64_t count = autoencoders(reading), components = reading.components;
        const auto input = [&](const char* name, Extents extents, double scale) {
            const Var var = tape.input(name, std::move(extents), true);
            fill_random(tape, var, static_cast<std::uint64_t>(var.index), scale);
            inputs.push_back(var);
            return var;
        };
        level.source = input("source", {kParents, vertices, 9, kLanes}, 0.7);
        if (reading.is_masked) level.mask = input("mask", {count, vertices}, 1.0);
        level.w_own = input("w_own", {count, 9, 9}, 0.3);
        level.w_ring = input("w_ring", {count, 9, 9}, 0.3);
        level.bias = input("bias", {count, 9}, 0.2);
        level.decoder_w_own = level.w_own;
        level.decoder_w_ring = level.w_ring;
        if (reading.has_own_decoder) {
            level.decoder_w_own = input("decoder_w_own", {count, 9, 9}, 0.3);
            level.decoder_w_ring = input("decoder_w_ring", {count, 9, 9}, 0.3);
        }
        level.decoder_bias = input("decoder_bias", {count, 9}, 0.2);
        level.component_weights = input("C", {count, components, vertices, 9}, 0.2);
        level.transposed_decoder = !reading.has_own_decoder;
        level.latent_activation = reading.latent;
        level.keeps_residual = reading.keeps_residual;
        level.joint = reading.joint;
        level.keeps_sum_error = reading.keeps_sum_error;

        acts.assign(static_cast<std::size_t>(count * vertices), 1);
        if (reading.is_partial) keep_patches(count, vertices);
        if (is_fused) {
            supports = std::make_unique<LevelSupports>(rings.rings, static_cast<int>(count));
            if (reading.is_partial) supports->set(acts);
            outputs = autoencoder(tape, rings, level, lanes, *supports);
        } else {
            record_small_ops();
        }
    }

    /// Autoencoder a acts on vertices a * 7 to a * 7 + 19 only, one of them on none at all.
    void keep_patches(std::int64_t count, std::int64_t vertices) {
        const std::span<T> weights = tape.value(level.component_weights);
        const auto rows = static_cast<std::size_t>(count * vertices);
        const std::size_t components = weights.size() / rows / 9;
        for (std::size_t i = 0; i < rows; ++i) {
            const std::size_t a = i / static_cast<std::size_t>(vertices);
            const std::size_t v = i % static_cast<std::size_t>(vertices);
            acts[i] = a != 1 && v >= a * 7 && v < a * 7 + 20 ? 1 : 0;
            if (acts[i] != 0) continue;
            for (std::size_t k = 0; k < components; ++k) {
                const std::size_t row =
                    (a * components + k) * static_cast<std::size_t>(vertices) + v;
                std::fill_n(weights.begin() + static_cast<std::ptrdiff_t>(row * 9), 9, T{0});
            }
        }
    }

    void record_small_ops() {
        Extents extents = tape.extents(level.source);
        const Var nothing = tape.input("nothing", extents);
        const Var x = masked_residual(tape, level.source, nothing, level.mask, level.joint);
        const Var f = mesh_conv(tape, rings, x, level.w_own, level.w_ring, level.bias, false,
                                Activation::tanh);
        outputs.code = project(tape, f, level.component_weights);
        if (level.latent_activation == Activation::tanh) outputs.code = tanh(tape, outputs.code);
        const Var y = mesh_conv(tape, rings, expand(tape, outputs.code, level.component_weights),
                                level.decoder_w_own, level.decoder_w_ring, level.decoder_bias,
                                level.transposed_decoder, Activation::tanh);
        outputs.error = squared_error(tape, x, y, lanes);
        if (level.keeps_residual) outputs.residual = masked_residual(tape, x, y, Var{}, true);
        if (level.keeps_sum_error) {
            const Var left = level.joint ? level.source : tape.input("source", extents);
            if (!level.joint) std::ranges::copy(tape.value(level.source), tape.value(left).begin());
            outputs.sum_error =
                squared_error(tape, sum_rows(tape, {left}, true), sum_rows(tape, {y}, true), lanes);
        }
    }

    /// Values of the outputs, then gradients of the inputs from random ones of the outputs.
    std::vector<std::vector<T>> run() {
        auto* level_op = dynamic_cast<Autoencoder<T>*>(tape.ops()[0].get());
        if (level_op != nullptr) level_op->expect_backward(expects_backward);
        tape.forward();
        std::vector<std::vector<T>> results;
        for (const Var var : {outputs.code, outputs.error, outputs.residual, outputs.sum_error}) {
            if (!var.valid()) continue;
            results.emplace_back(tape.value(var).begin(), tape.value(var).end());
            const CounterRandom random(17, results.size());
            for (std::size_t i = 0; i < tape.grad(var).size(); ++i) {
                const bool is_foreseen = error_grad != 0 && var.index == outputs.error.index;
                tape.grad(var)[i] = static_cast<T>(is_foreseen ? error_grad : random.normal(i));
            }
        }
        const auto ops = tape.ops();
        for (auto op = ops.rbegin(); op != ops.rend(); ++op) {
            if (tape.needs_grad((*op)->output())) (*op)->backward(tape);
        }
        for (const Var var : inputs) {
            results.emplace_back(tape.grad(var).begin(), tape.grad(var).end());
        }
        if (!forgets_outside) return results;
        // Outside the support the gradient of C is left out.
        std::vector<T>& last = results.back();
        const std::size_t vertices = static_cast<std::size_t>(rings.vertex_count());
        const std::size_t components = last.size() / acts.size() / 9;
        for (std::size_t i = 0; i < last.size(); ++i) {
            const std::size_t v = i / 9 % vertices, a = i / 9 / vertices / components;
            if (acts[a * vertices + v] == 0) last[i] = 0;
        }
        return results;
    }
};

class FusedAutoencoder : public testing::TestWithParam<Reading> {
  protected:
    static TriangleMesh mesh() {
        TriangleMesh mesh = shapes::grid(13, 11);  // 143 vertices: two chunks of them
        mesh.vertices.push_back({9, 9, 9});        // in no face: its ring is empty
        return mesh;
    }
    template <class T>
    static std::vector<std::vector<T>> run(bool is_fused) {
        LevelFixture<T> fixture(mesh(), GetParam(), is_fused);
        return fixture.run();
    }
};

/// Largest difference as part of the largest entry.
template <class T>
double deviation(const std::vector<T>& got, const std::vector<double>& wanted) {
    if (got.size() != wanted.size()) return INFINITY;
    double largest = 0, difference = 0;
    for (std::size_t i = 0; i < got.size(); ++i) {
        largest = std::max(largest, std::abs(wanted[i]));
        const double d = std::abs(static_cast<double>(got[i]) - wanted[i]);
        if (!(d <= difference)) difference = d;
    }
    return largest > 0 ? difference / largest : difference;
}

// Outputs and gradients are those of the small ops.
TEST_P(FusedAutoencoder, EqualsTheSmallOps) {
    const auto fused = run<double>(true), small = run<double>(false);
    ASSERT_EQ(fused.size(), small.size());
    for (std::size_t n = 0; n < fused.size(); ++n) {
        EXPECT_TRUE(deviation(fused[n], small[n]) <= 1e-12)
            << "result " << n << ": " << deviation(fused[n], small[n]);
    }
}

// Float against double: every entry is a sum of terms of random signs, whose roundoff grows as the
// sum does; what does not cancel is bounded by a number of operations per vertex (two products of
// 9 x 18, K products each way, six neighbours) times unit roundoff and the largest entry.
TEST_P(FusedAutoencoder, FloatAgreesWithDoubleWithinRoundoff) {
    const auto single = run<float>(true);
    const auto twice = run<double>(true);
    for (std::size_t n = 0; n < single.size(); ++n) {
        EXPECT_TRUE(deviation(single[n], twice[n]) <= 100 * kUnitRoundoff)
            << "result " << n << ": " << deviation(single[n], twice[n]) / kUnitRoundoff;
    }
}

// Doing a part of backward early changes nothing, whether the gradient of the error comes out as
// foreseen or not.
TEST_P(FusedAutoencoder, MayDoAPartOfBackwardEarly) {
    for (const double error_grad : {0.0, 1.0}) {  // random ones, and the weight that is foreseen
        LevelFixture<double> late(mesh(), GetParam(), true), early(mesh(), GetParam(), true);
        late.error_grad = early.error_grad = error_grad;
        early.expects_backward = true;
        EXPECT_EQ(early.run(), late.run()) << error_grad;
    }
}

TEST_P(FusedAutoencoder, ThreadsDoNotChangeABit) {
    set_thread_count(1);
    const auto one = run<float>(true);
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        EXPECT_EQ(run<float>(true), one) << threads << " threads";
    }
    set_thread_count(0);
}

// The gradient at every vertex, by which supports grow, is that of the small ops, where it acts and
// where it does not.
TEST_P(FusedAutoencoder, KnowsTheGradientOfComponentsWhereNothingActs) {
    if (GetParam().keeps_residual) return;  // has no supports
    LevelFixture<double> fused(mesh(), GetParam(), true), small(mesh(), GetParam(), false);
    fused.run();
    small.forgets_outside = false;
    const std::vector<double> wanted = small.run().back();
    const auto& op = dynamic_cast<const Autoencoder<double>&>(*fused.tape.ops()[0]);
    const int vertices = mesh().vertex_count(), components = GetParam().components;
    AlignedVector<double> packed;
    std::vector<double> got;
    for (int a = 0; a < fused.autoencoders(GetParam()); ++a) {
        op.full_component_grads(fused.tape, a, packed);
        for (int k = 0; k < components; ++k) {
            for (int i = 0; i < vertices * 9; ++i) {
                got.push_back(packed[static_cast<std::size_t>(i * op.padded_components() + k)]);
            }
        }
    }
    EXPECT_TRUE(deviation(got, wanted) <= 1e-12) << deviation(got, wanted);
}

INSTANTIATE_TEST_SUITE_P(
    Readings, FusedAutoencoder,
    testing::Values(
        Reading{"masked"}, Reading{"partial", true, true}, Reading{"residual", true, false, true},
        Reading{"unmasked", false}, Reading{"unmasked_partial", false, true},
        Reading{"own_decoder", true, true, false, true},
        Reading{"latent_tanh", true, true, false, false, Activation::tanh},
        Reading{"ten_components", true, false, true, false, Activation::none, 10},
        Reading{"separate", true, true, false, false, Activation::none, 5, false},
        Reading{"ten_partial", true, true, false, false, Activation::none, 10},
        Reading{"one_component", true, true, false, false, Activation::none, 1},
        Reading{"fifty_components", false, true, false, false, Activation::none, 50},
        with_sum({"sum", true}), with_sum({"sum_partial", true, true}),
        with_sum({"sum_residual", true, false, true}),
        with_sum({"sum_unmasked_partial", false, true}),
        with_sum({"sum_separate", true, true, false, false, Activation::none, 5, false}),
        Reading{"eleven_components", true, true, false, false, Activation::none, 11}),
    [](const auto& reading) { return reading.param.name; });

// Changed supports are followed: the result is that of an op that had them from the start.
TEST(FusedAutoencoderSupports, MayChangeBetweenPasses) {
    TriangleMesh mesh = shapes::grid(13, 11);
    const Reading partial{"partial", true, true};
    LevelFixture<double> from_start(mesh, partial, true), changed(mesh, partial, true);
    changed.supports->set(std::vector<std::uint8_t>(changed.acts.size(), 1));
    changed.tape.forward();
    changed.supports->set(changed.acts);
    EXPECT_EQ(changed.run(), from_start.run());
}

}  // namespace
}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
#include "nn/ops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "gradient_check.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"
#include "nn/spectral_vae.h"
#include "nn/stacked_model.h"
#include "op_table.h"
#include "shapes.h"

namespace mscomp::nn {
namespace {

constexpr double kGradientTolerance = 1e-6;

using CaseAndSize = std::tuple<OpCase<double>, FixtureSize>;

class EveryOp : public testing::TestWithParam<CaseAndSize> {
  protected:
    static bool wide() { return std::get<1>(GetParam()) == FixtureSize::wide; }
    static std::unique_ptr<OpFixture<double>> fixture_of_case() {
        return make_fixture(std::get<0>(GetParam()), std::get<1>(GetParam()));
    }
};

std::string test_name(const testing::TestParamInfo<CaseAndSize>& info) {
    std::string name = std::get<0>(info.param).name;
    if (std::get<1>(info.param) == FixtureSize::wide) name += " wide";
    for (char& c : name) {
        if (c == ' ') c = '_';
    }
    return name;
}

TEST_P(EveryOp, BackwardAgreesWithFiniteDifferences) {
    set_thread_count(1);  // thousands of tiny passes: starting threads would take most of the time
    const std::size_t outputs = 1 + fixture_of_case()->further_outputs.size();
    for (std::size_t n = 0; n < outputs; ++n) {
        const auto fixture = fixture_of_case();
        const Var output = n == 0 ? fixture->output : fixture->further_outputs[n - 1];
        const GradientReport report = wide() || outputs > 1
                                          ? check_gradients(fixture->tape, output, fixture->inputs,
                                                            std::get<0>(GetParam()).samples)
                                          : check_gradients(fixture->tape, output, fixture->inputs);
        EXPECT_TRUE(report.within(kGradientTolerance))
            << fixture->tape.name(output) << ": " << report.worst_error << " at " << report.where;
    }
    set_thread_count(0);
}

TEST_P(EveryOp, ForwardAgreesWithTheNaiveReference) {
    const auto fixture = fixture_of_case();
    fixture->tape.forward();
    const std::vector<double> expected = fixture->tape.ops()[0]->reference(fixture->tape);
    const std::span<double> got = fixture->tape.value(fixture->output);
    ASSERT_EQ(got.size(), expected.size());
    for (std::size_t i = 0; i < got.size(); ++i) {
        EXPECT_TRUE(std::abs(got[i] - expected[i]) <= 1e-12 * (1 + std::abs(expected[i])))
            << i << ": " << got[i] << " instead of " << expected[i];
    }
}

// Gradients accumulate: a second backward pass on parameters' memory would double them; within one
// pass the gradient of an input that was preset is added to.
TEST_P(EveryOp, BackwardAddsToWhatIsThere) {
    const auto fixture = fixture_of_case();
    Tape<double>& tape = fixture->tape;
    tape.forward();
    std::fill(tape.grad(fixture->output).begin(), tape.grad(fixture->output).end(), 1.0);
    Op<double>& op = *tape.ops()[0];
    op.backward(tape);
    std::vector<std::vector<double>> once;
    for (const Var input : fixture->inputs) {
        once.emplace_back(tape.grad(input).begin(), tape.grad(input).end());
    }
    op.forward(tape);  // backward may use up what forward left
    op.backward(tape);
    for (std::size_t n = 0; n < once.size(); ++n) {
        for (std::size_t i = 0; i < once[n].size(); ++i) {
            EXPECT_TRUE(std::abs(tape.grad(fixture->inputs[n])[i] - 2 * once[n][i]) <=
                        1e-12 * (1 + std::abs(once[n][i])));
        }
    }
}

TEST_P(EveryOp, ThreadsDoNotChangeABit) {
    std::vector<std::vector<double>> results;
    for (const int threads : {1, 2, 7}) {
        set_thread_count(threads);
        const auto fixture = fixture_of_case();
        check_gradients(fixture->tape, fixture->output, {});
        std::vector<double>& result =
            results.emplace_back(fixture->tape.value(fixture->output).begin(),
                                 fixture->tape.value(fixture->output).end());
        for (const Var input : fixture->inputs) {
            result.insert(result.end(), fixture->tape.grad(input).begin(),
                          fixture->tape.grad(input).end());
        }
    }
    set_thread_count(0);
    EXPECT_EQ(results[0], results[1]);
    EXPECT_EQ(results[0], results[2]);
}

INSTANTIATE_TEST_SUITE_P(Table, EveryOp,
                         testing::Combine(testing::ValuesIn(op_table<double>()),
                                          testing::Values(FixtureSize::narrow, FixtureSize::wide)),
                         test_name);

/// Output and then the gradients of all inputs after one backward pass from random gradients.
template <class T>
std::vector<std::vector<T>> forward_and_backward(const OpCase<T>& op_case, FixtureSize size) {
    const auto fixture = make_fixture(op_case, size);
    Tape<T>& tape = fixture->tape;
    tape.forward();
    const std::span<T> seed = tape.grad(fixture->output);
    const CounterRandom random(41, 0);
    for (std::size_t i = 0; i < seed.size(); ++i) seed[i] = static_cast<T>(random.normal(i));
    tape.ops()[0]->backward(tape);
    std::vector<std::vector<T>> results{
        {tape.value(fixture->output).begin(), tape.value(fixture->output).end()}};
    for (const Var input : fixture->inputs) {
        results.emplace_back(tape.grad(input).begin(), tape.grad(input).end());
    }
    return results;
}

class FloatOps : public testing::TestWithParam<FixtureSize> {};

// Float against double. Terms have random signs, so that a sum of n of them and the roundoff it
// collects both grow like sqrt(n): the bound is a number of terms that does not grow, that of nine
// channels of a vertex with its ring for each product in a chain, times unit roundoff and the
// largest entry.
TEST_P(FloatOps, AgreeWithDoubleWithinRoundoff) {
    const auto single = op_table<float>();
    const auto twice = op_table<double>();
    for (std::size_t n = 0; n < single.size(); ++n) {
        const auto got = forward_and_backward(single[n], GetParam());
        const auto expected = forward_and_backward(twice[n], GetParam());
        ASSERT_EQ(got.size(), expected.size());
        for (std::size_t j = 0; j < got.size(); ++j) {
            ASSERT_EQ(got[j].size(), expected[j].size());
            double largest = 0, worst = 0;
            for (std::size_t i = 0; i < got[j].size(); ++i) {
                const double error = std::abs(static_cast<double>(got[j][i]) - expected[j][i]);
                if (!(error <= worst)) worst = error;  // a NaN stays
                largest = std::max(largest, std::abs(expected[j][i]));
            }
            EXPECT_GT(largest, 0) << single[n].name << ", tensor " << j;
            EXPECT_TRUE(worst <= single[n].rounded_terms * kUnitRoundoff * largest)
                << single[n].name << (j == 0 ? ", output" : ", gradient of input ")
                << (j == 0 ? "" : std::to_string(j - 1)) << ": " << worst << " of " << largest;
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Sizes, FloatOps, testing::Values(FixtureSize::narrow, FixtureSize::wide),
                         [](const auto& each) {
                             return each.param == FixtureSize::wide ? "wide" : "narrow";
                         });

/// tanh whose derivative forgets a square: exactly what the table has to find.
class WrongTanh final : public Op<double> {
  public:
    WrongTanh(Tape<double>& tape, Var x) : x_(x), y_(tape.result("y", tape.extents(x), true)) {}
    std::string_view name() const override { return "wrong_tanh"; }
    Var output() const override { return y_; }
    void forward(Tape<double>& tape) override {
        for (std::size_t i = 0; i < tape.value(x_).size(); ++i) {
            tape.value(y_)[i] = std::tanh(tape.value(x_)[i]);
        }
    }
    void backward(Tape<double>& tape) override {
        for (std::size_t i = 0; i < tape.value(x_).size(); ++i) {
            tape.grad(x_)[i] += tape.grad(y_)[i] * (1 - tape.value(y_)[i]);
        }
    }
    std::vector<double> reference(Tape<double>&) const override { return {}; }

  private:
    Var x_, y_;
};

TEST(GradientCheck, RejectsAPlantedWrongOp) {
    Tape<double> tape;
    const Var x = tape.input("x", {4}, true);
    fill_random(tape, x, 0);
    auto wrong = std::make_unique<WrongTanh>(tape, x);
    const Var y = wrong->output();
    tape.record(std::move(wrong));
    EXPECT_FALSE(check_gradients(tape, y, {x}).within(kGradientTolerance));
}

TEST(GradientCheck, RejectsNaN) {
    Tape<double> tape;
    const Var x = tape.input("x", {4}, true);
    fill_random(tape, x, 0);
    tape.value(x)[2] = std::nan("");
    EXPECT_FALSE(check_gradients(tape, tanh(tape, x), {x}).within(kGradientTolerance));
}

TEST(GradientTable, HoldsEveryOpThatAModelRecords) {
    std::set<std::string, std::less<>> in_table;
    for (const auto& op_case : op_table<double>()) {
        in_table.emplace(make_fixture(op_case)->tape.ops()[0]->name());
    }
    const TriangleMesh mesh = shapes::grid(4, 4);
    LineDistances distances(mesh.vertex_count());
    StackedConfig config;
    config.levels = {{3, 0.4, 1.0, {}}, {2, 0.2, 1.0, {}}};
    config.latent_activation = config.decoder_fc_activation = Activation::tanh;
    StackedModel<double> model(config, {}, one_rings_of_faces(16, mesh.faces), distances, {4});
    for (const auto& op : model.tape().ops())
        EXPECT_TRUE(in_table.contains(op->name())) << op->name();
    for (const bool fused : {false, true}) {
        SpectralVae<double>::Options options;
        options.batch = 4;
        options.fused = fused;
        SpectralVae<double> vae({}, {}, one_rings_of_faces(16, mesh.faces), {}, distances, options);
        for (const auto& op : vae.tape().ops()) {
            EXPECT_TRUE(in_table.contains(op->name())) << op->name();
        }
    }
}

// [A] eq. 6: the masks of the children of one autoencoder sum to one at every vertex, even where no
// component acts and however sharp they are.
TEST(AttentionMask, ColumnsSumToOne) {
    for (const double power : {1.0, 4.0}) {
        Tape<double> tape;
        const Var c = tape.input("C", {2, 3, 10, 9}, true);
        fill_random(tape, c, 1);
        for (int row = 0; row < 3; ++row) {
            std::fill_n(tape.value(c).begin() + row * 90, 9, 0.0);  // vertex 0 of autoencoder 0
        }
        const Var mask = attention_mask(tape, c, power, 1e-12);
        const GradientReport report = check_gradients(tape, mask, {});
        EXPECT_TRUE(report.within(0));
        for (int a = 0; a < 2; ++a) {
            for (int v = 0; v < 10; ++v) {
                double sum = 0;
                for (int k = 0; k < 3; ++k) {
                    sum += tape.value(mask)[static_cast<std::size_t>((a * 3 + k) * 10 + v)];
                }
                EXPECT_NEAR(sum, 1, 1e-12);
            }
        }
        for (const double g : tape.grad(c)) EXPECT_TRUE(std::isfinite(g));
    }
}

/// Puts numbers into the lanes without shape, other ones into every input.
void fill_padding(OpFixture<double>& fixture) {
    const auto active = static_cast<std::size_t>(fixture.lanes.active);
    double filler = 1e6;
    for (const Var input : fixture.inputs) {
        const std::span<double> values = fixture.tape.value(input);
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (i % fixture.lanes.weight.size() >= active) values[i] = filler;
        }
        filler *= -3;
    }
}

// Padding lanes hold no shape: whatever they hold changes neither loss nor gradients.
TEST(BatchLosses, IgnoreLanesWithoutShape) {
    for (const auto& op_case : op_table<double>()) {
        if (op_case.name != "squared_error" && op_case.name != "range_penalty") continue;
        for (const FixtureSize size : {FixtureSize::narrow, FixtureSize::wide}) {
            const auto clean = make_fixture(op_case, size), padded = make_fixture(op_case, size);
            fill_padding(*padded);
            check_gradients(clean->tape, clean->output, {});
            check_gradients(padded->tape, padded->output, {});
            EXPECT_EQ(padded->tape.value(padded->output)[0], clean->tape.value(clean->output)[0]);
            const std::size_t lanes = clean->lanes.weight.size();
            for (const Var input : clean->inputs) {
                const std::span<double> want = clean->tape.grad(input);
                const std::span<double> got = padded->tape.grad(input);
                for (std::size_t i = 0; i < got.size(); ++i) {
                    const bool holds_shape =
                        i % lanes < static_cast<std::size_t>(clean->lanes.active);
                    EXPECT_EQ(got[i], holds_shape ? want[i] : 0.0) << op_case.name << " " << i;
                }
            }
        }
    }
}

}  // namespace
}  // namespace mscomp::nn

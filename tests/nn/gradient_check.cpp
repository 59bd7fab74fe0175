// SPDX-License-Identifier: MIT
#include "gradient_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <string_view>

#include "mscomp/base/random.h"

namespace mscomp::nn {
namespace {

class RandomDot final : public Op<double> {
  public:
    RandomDot(Tape<double>& tape, Var x) : x_(x), y_(tape.result("random_dot", {1}, true)) {
        const CounterRandom random(99, 0);
        for (std::size_t i = 0; i < tape.value(x).size(); ++i) weights_.push_back(random.normal(i));
    }
    std::string_view name() const override { return "random_dot"; }
    Var output() const override { return y_; }
    void forward(Tape<double>& tape) override { tape.value(y_)[0] = reference(tape)[0]; }
    void backward(Tape<double>& tape) override {
        for (std::size_t i = 0; i < weights_.size(); ++i) {
            tape.grad(x_)[i] += weights_[i] * tape.grad(y_)[0];
        }
    }
    std::vector<double> reference(Tape<double>& tape) const override {
        long double sum = 0;  // differences of it are divided by the step
        for (std::size_t i = 0; i < weights_.size(); ++i) {
            sum += static_cast<long double>(weights_[i]) * tape.value(x_)[i];
        }
        return {static_cast<double>(sum)};
    }

  private:
    Var x_, y_;
    std::vector<double> weights_;
};

/// One random element of each of `samples` equal pieces; all elements where there are no more.
std::vector<std::size_t> elements_to_check(std::size_t count, std::size_t samples) {
    std::vector<std::size_t> elements(std::min(count, samples));
    if (samples >= count) {
        std::iota(elements.begin(), elements.end(), std::size_t{0});
        return elements;
    }
    const CounterRandom random(98, 0);
    const double piece = static_cast<double>(count) / static_cast<double>(samples);
    for (std::size_t s = 0; s < samples; ++s) {
        elements[s] =
            static_cast<std::size_t>((static_cast<double>(s) + random.uniform(s)) * piece);
    }
    return elements;
}

}  // namespace

GradientReport check_gradients(Tape<double>& tape, Var output, const std::vector<Var>& inputs,
                               std::size_t samples) {
    auto dot = std::make_unique<RandomDot>(tape, output);
    const Var root = dot->output();
    tape.record(std::move(dot));
    tape.forward();
    tape.backward(root);

    GradientReport report;
    for (const Var input : inputs) {
        const std::vector<double> gradient(tape.grad(input).begin(), tape.grad(input).end());
        double largest = 0;
        for (const double g : gradient) largest = std::max(largest, std::abs(g));
        for (const std::size_t i : elements_to_check(gradient.size(), samples)) {
            double& x = tape.value(input)[i];
            const double kept = x, h = 1e-3 * std::max(1.0, std::abs(x));
            const auto at = [&](double offset) {
                x = kept + offset;
                tape.forward();
                return tape.value(root)[0];
            };
            const double slope = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
            x = kept;
            const double scale = std::max({std::abs(slope), std::abs(gradient[i]), 1e-2 * largest});
            double error = std::abs(slope - gradient[i]);
            if (scale > 0) error /= scale;  // a NaN stays one
            if (!(error <= report.worst_error)) {
                report.worst_error = error;
                report.where = fmt::format("{}[{}]: backward {}, differences {}", tape.name(input),
                                           i, gradient[i], slope);
            }
        }
    }
    return report;
}

template <class T>
void fill_random(Tape<T>& tape, Var var, std::uint64_t stream, double scale) {
    const CounterRandom random(5, stream);
    for (std::size_t i = 0; i < tape.value(var).size(); ++i) {
        tape.value(var)[i] = static_cast<T>(scale * random.normal(i));
    }
}

template void fill_random(Tape<float>&, Var, std::uint64_t, double);
template void fill_random(Tape<double>&, Var, std::uint64_t, double);

}  // namespace mscomp::nn

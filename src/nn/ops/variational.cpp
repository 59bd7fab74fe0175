// SPDX-License-Identifier: MIT
// What the latent space of the VAE consists of: samples, their divergence from the prior, and the
// term that keeps learned ranges small.
#include <cmath>

#include "batch.h"
#include "mscomp/base/index.h"
#include "nn/spectral_ops.h"

namespace mscomp::nn {
namespace {

template <class T>
class OffsetSpread final : public Op<T> {
  public:
    OffsetSpread(Tape<T>& tape, Var moments, double offset)
        : moments_(moments),
          offset_(static_cast<T>(offset)),
          sum_(tape.result("offset_spread", tape.extents(moments), true)) {}

    std::string_view name() const override { return "offset_spread"; }
    Var output() const override { return sum_; }

    void forward(Tape<T>& tape) override {
        const std::span<T> from = tape.value(moments_), to = tape.value(sum_);
        const std::size_t half = from.size() / 2;
        for (std::size_t i = 0; i < half; ++i) {
            to[i] = from[i];
            to[half + i] = from[half + i] + offset_;
        }
    }

    void backward(Tape<T>& tape) override {
        for (std::size_t i = 0; i < tape.grad(sum_).size(); ++i) {
            tape.grad(moments_)[i] += tape.grad(sum_)[i];
        }
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> sum(tape.value(moments_).begin(), tape.value(moments_).end());
        for (std::size_t i = sum.size() / 2; i < sum.size(); ++i) sum[i] += offset_;
        return sum;
    }

  private:
    Var moments_;
    T offset_;
    Var sum_;
};

template <class T>
class SampleCodes final : public Op<T> {
  public:
    SampleCodes(Tape<T>& tape, Var moments, Var noise, Spread spread)
        : moments_(moments),
          noise_(noise),
          spread_(spread),
          codes_(tape.result("sampled_codes", tape.extents(noise), true)) {}

    std::string_view name() const override { return "sample_codes"; }
    Var output() const override { return codes_; }

    void forward(Tape<T>& tape) override {
        const std::span<T> codes = tape.value(codes_);
        for (std::size_t i = 0; i < codes.size(); ++i) {
            codes[i] = mean(tape)[i] + sigma(tape, i) * tape.value(noise_)[i];
        }
    }

    void backward(Tape<T>& tape) override {
        const std::span<T> slope = tape.grad(codes_), moments = tape.grad(moments_);
        for (std::size_t i = 0; i < slope.size(); ++i) {
            moments[i] += slope[i];
            const T by_sigma = slope[i] * tape.value(noise_)[i];
            moments[slope.size() + i] +=
                spread_ == Spread::linear ? by_sigma : by_sigma * sigma(tape, i) / 2;
            if (tape.needs_grad(noise_)) tape.grad(noise_)[i] += slope[i] * sigma(tape, i);
        }
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> codes;
        const std::size_t count = tape.value(noise_).size();
        for (std::size_t i = 0; i < count; ++i) {
            const T s = tape.value(moments_)[count + i];
            codes.push_back(tape.value(moments_)[i] +
                            (spread_ == Spread::linear ? s : std::exp(s / 2)) *
                                tape.value(noise_)[i]);
        }
        return codes;
    }

  private:
    std::span<T> mean(Tape<T>& tape) const { return tape.value(moments_); }
    T sigma(Tape<T>& tape, std::size_t i) const {
        const T s = tape.value(moments_)[tape.value(noise_).size() + i];
        return spread_ == Spread::linear ? s : std::exp(s / 2);
    }

    Var moments_, noise_;
    Spread spread_;
    Var codes_;
};

template <class T>
class KlDivergence final : public Op<T> {
  public:
    KlDivergence(Tape<T>& tape, Var moments, Spread spread, double epsilon,
                 const LaneMask<T>& lane_mask)
        : moments_(moments),
          spread_(spread),
          epsilon_(epsilon),
          lane_mask_(lane_mask),
          components_(tape.extents(moments)[1]),
          lanes_(tape.extents(moments)[2]),
          kl_(tape.result("kl_divergence", {1}, true)) {}

    std::string_view name() const override { return "kl_divergence"; }
    Var output() const override { return kl_; }

    void forward(Tape<T>& tape) override {
        double sum = 0;
        for_each_code([&](std::size_t i) {
            const auto mu = static_cast<double>(tape.value(moments_)[i]);
            const auto s = static_cast<double>(tape.value(moments_)[i + spread_at()]);
            const double variance = spread_ == Spread::linear ? s * s : std::exp(s);
            const double log = spread_ == Spread::linear ? std::log(variance + epsilon_) : s;
            sum += 0.5 * (mu * mu + variance - 1 - log);
        });
        tape.value(kl_)[0] = static_cast<T>(sum / lane_mask_.active);
    }

    void backward(Tape<T>& tape) override {
        const double factor = static_cast<double>(tape.grad(kl_)[0]) / lane_mask_.active;
        const std::span<T> slope = tape.grad(moments_);
        for_each_code([&](std::size_t i) {
            const auto mu = static_cast<double>(tape.value(moments_)[i]);
            const auto s = static_cast<double>(tape.value(moments_)[i + spread_at()]);
            const double by_spread =
                spread_ == Spread::linear ? s - s / (s * s + epsilon_) : 0.5 * (std::exp(s) - 1);
            slope[i] += static_cast<T>(factor * mu);
            slope[i + spread_at()] += static_cast<T>(factor * by_spread);
        });
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        T kl = 0;
        for (int m = 0; m < lane_mask_.active; ++m) {
            for (std::int64_t k = 0; k < components_; ++k) {
                const auto i = at(k * lanes_ + m);
                const T mu = tape.value(moments_)[i], s = tape.value(moments_)[i + spread_at()];
                const T sigma = spread_ == Spread::linear ? s : std::exp(s / 2);
                const T inside =
                    sigma * sigma + (spread_ == Spread::linear ? static_cast<T>(epsilon_) : T{0});
                kl += (mu * mu + sigma * sigma - 1 - std::log(inside)) / 2;
            }
        }
        return {kl / static_cast<T>(lane_mask_.active)};
    }

  private:
    std::size_t spread_at() const { return at(components_ * lanes_); }
    template <class Visit>
    void for_each_code(Visit visit) const {
        for (std::int64_t k = 0; k < components_; ++k) {
            for (std::int64_t m = 0; m < lane_mask_.active; ++m) {
                visit(at(k * lanes_ + m));
            }
        }
    }

    Var moments_;
    Spread spread_;
    double epsilon_;
    const LaneMask<T>& lane_mask_;
    std::int64_t components_, lanes_;
    Var kl_;
};

template <class T>
class RangeTermOp final : public Op<T> {
  public:
    RangeTermOp(Tape<T>& tape, Var ranges, RangeTerm kind)
        : ranges_(ranges), kind_(kind), phi_(tape.result("range_term", {1}, true)) {}

    std::string_view name() const override { return "range_term"; }
    Var output() const override { return phi_; }

    void forward(Tape<T>& tape) override {
        tape.value(phi_)[0] = kind_ == RangeTerm::l2 ? norm(tape) : positive_sum(tape);
    }

    void backward(Tape<T>& tape) override {
        const T slope = tape.grad(phi_)[0], length = norm(tape);
        for (std::size_t k = 0; k < tape.value(ranges_).size(); ++k) {
            const T d = tape.value(ranges_)[k];
            if (kind_ == RangeTerm::l2) {
                if (length > 0) tape.grad(ranges_)[k] += slope * d / length;
            } else if (d > 0) {
                tape.grad(ranges_)[k] += slope;
            }
        }
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        T sum = 0;
        for (const T d : tape.value(ranges_)) {
            sum += kind_ == RangeTerm::l2 ? d * d : (d + std::abs(d)) / 2;
        }
        return {kind_ == RangeTerm::l2 ? std::sqrt(sum) : sum};
    }

  private:
    T norm(Tape<T>& tape) const {
        T square = 0;
        for (const T d : tape.value(ranges_)) square += d * d;
        return std::sqrt(square);
    }
    T positive_sum(Tape<T>& tape) const {
        T sum = 0;
        for (const T d : tape.value(ranges_)) sum += d < 0 ? T{0} : d;  // a NaN has to come through
        return sum;
    }

    Var ranges_;
    RangeTerm kind_;
    Var phi_;
};

}  // namespace

template <class T>
Var offset_spread(Tape<T>& tape, Var moments, double offset) {
    return record_op<OffsetSpread<T>>(tape, moments, offset);
}

template <class T>
Var sample_codes(Tape<T>& tape, Var moments, Var noise, Spread spread) {
    return record_op<SampleCodes<T>>(tape, moments, noise, spread);
}

template <class T>
Var kl_divergence(Tape<T>& tape, Var moments, Spread spread, double epsilon,
                  const LaneMask<T>& lanes) {
    return record_op<KlDivergence<T>>(tape, moments, spread, epsilon, lanes);
}

template <class T>
Var range_term(Tape<T>& tape, Var ranges, RangeTerm kind) {
    return record_op<RangeTermOp<T>>(tape, ranges, kind);
}

template Var offset_spread(Tape<float>&, Var, double);
template Var offset_spread(Tape<double>&, Var, double);
template Var sample_codes(Tape<float>&, Var, Var, Spread);
template Var sample_codes(Tape<double>&, Var, Var, Spread);
template Var kl_divergence(Tape<float>&, Var, Spread, double, const LaneMask<float>&);
template Var kl_divergence(Tape<double>&, Var, Spread, double, const LaneMask<double>&);
template Var range_term(Tape<float>&, Var, RangeTerm);
template Var range_term(Tape<double>&, Var, RangeTerm);

}  // namespace mscomp::nn

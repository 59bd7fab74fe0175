// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "../kernels/kernels.h"
#include "batch.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "nn/ops.h"

namespace mscomp::nn {
namespace {

template <class T>
class SquaredError final : public Op<T> {
  public:
    SquaredError(Tape<T>& tape, Var x, Var y, const LaneMask<T>& lane_mask)
        : x_(x),
          y_(y),
          lane_mask_(lane_mask),
          autoencoders_(tape.extents(x)[0]),
          vertices_(tape.extents(x)[1]),
          lanes_(static_cast<int>(tape.extents(x)[3])),
          error_(tape.result("squared_error", {autoencoders_}, true)) {}

    std::string_view name() const override { return "squared_error"; }
    Var output() const override { return error_; }

    void forward(Tape<T>& tape) override {
        const std::int64_t chunks = chunk_count(vertices_);
        partials_.assign(at(autoencoders_ * chunks), 0.0);
        for_each_chunk(autoencoders_, vertices_, [&](std::int64_t a, std::int64_t c, int b, int e) {
            partials_[at(a * chunks + c)] = kernels<T>().squared_error(
                tape.value(x_).data() + a * rows(), tape.value(y_).data() + a * rows(),
                lane_mask_.weight.data(), lanes_, b, e);
        });
        for (std::int64_t a = 0; a < autoencoders_; ++a) {
            const auto first = partials_.begin() + a * chunks;
            tape.value(error_)[at(a)] =
                static_cast<T>(std::accumulate(first, first + chunks, 0.0) / lane_mask_.active);
        }
    }

    void backward(Tape<T>& tape) override {
        for_each_chunk(autoencoders_, vertices_, [&](std::int64_t a, std::int64_t, int b, int e) {
            const T factor = 2 * tape.grad(error_)[at(a)] / static_cast<T>(lane_mask_.active);
            kernels<T>().squared_error_backward(
                tape.value(x_).data() + a * rows(), tape.value(y_).data() + a * rows(),
                lane_mask_.weight.data(), factor, lanes_, b, e,
                tape.needs_grad(x_) ? tape.grad(x_).data() + a * rows() : nullptr,
                tape.needs_grad(y_) ? tape.grad(y_).data() + a * rows() : nullptr);
        });
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> error(at(autoencoders_), T{0});
        for (std::int64_t i = 0; i < autoencoders_ * rows(); ++i) {
            const auto place = at(i);
            const T difference = tape.value(x_)[place] - tape.value(y_)[place];
            error[at(i / rows())] += lane_mask_.weight[at(i % lanes_)] * difference * difference /
                                     static_cast<T>(lane_mask_.active);
        }
        return error;
    }

  private:
    std::int64_t rows() const { return vertices_ * kFeatureDim * lanes_; }

    Var x_, y_;
    const LaneMask<T>& lane_mask_;
    std::int64_t autoencoders_, vertices_;
    int lanes_;
    Var error_;
    std::vector<double> partials_;
};

template <class T>
class RangePenalty final : public Op<T> {
  public:
    RangePenalty(Tape<T>& tape, Var codes, double limit, const LaneMask<T>& lane_mask)
        : codes_(codes),
          limit_(static_cast<T>(limit)),
          lane_mask_(lane_mask),
          autoencoders_(tape.extents(codes)[0]),
          components_(tape.extents(codes)[1]),
          lanes_(tape.extents(codes)[2]),
          penalty_(tape.result("range_penalty", {autoencoders_}, true)) {}

    std::string_view name() const override { return "range_penalty"; }
    Var output() const override { return penalty_; }

    void forward(Tape<T>& tape) override {
        for (std::int64_t a = 0; a < autoencoders_; ++a) {
            T sum = 0;
            for (std::int64_t k = 0; k < components_; ++k) {
                const T excess = std::abs(tape.value(codes_)[widest(tape, a, k)]) - limit_;
                // Not std::max: a NaN has to come through.
                sum += excess < 0 ? T{0} : excess;
            }
            tape.value(penalty_)[at(a)] = sum / static_cast<T>(components_);
        }
    }

    void backward(Tape<T>& tape) override {
        for (std::int64_t a = 0; a < autoencoders_; ++a) {
            const T factor = tape.grad(penalty_)[at(a)] / static_cast<T>(components_);
            for (std::int64_t k = 0; k < components_; ++k) {
                const std::size_t place = widest(tape, a, k);
                const T code = tape.value(codes_)[place];
                if (std::abs(code) > limit_)
                    tape.grad(codes_)[place] += code > 0 ? factor : -factor;
            }
        }
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> penalty(at(autoencoders_), T{0});
        for (std::int64_t row = 0; row < autoencoders_ * components_; ++row) {
            T largest = 0;
            for (std::int64_t m = 0; m < lane_mask_.active; ++m) {
                const auto place = at(row * lanes_ + m);
                largest = std::max(largest, std::abs(tape.value(codes_)[place]));
            }
            penalty[at(row / components_)] +=
                std::max(largest - limit_, T{0}) / static_cast<T>(components_);
        }
        return penalty;
    }

  private:
    /// Where |z| is largest over the active shapes, the first of equals.
    std::size_t widest(Tape<T>& tape, std::int64_t a, std::int64_t k) const {
        const auto first = at((a * components_ + k) * lanes_);
        std::size_t best = first;
        for (int m = 0; m < lane_mask_.active; ++m) {
            const std::size_t place = first + at(m);
            if (!(std::abs(tape.value(codes_)[place]) <= std::abs(tape.value(codes_)[best]))) {
                best = place;
            }
        }
        return best;
    }

    Var codes_;
    T limit_;
    const LaneMask<T>& lane_mask_;
    std::int64_t autoencoders_, components_, lanes_;
    Var penalty_;
};

template <class T>
class WeightedSum final : public Op<T> {
  public:
    WeightedSum(Tape<T>& tape, std::vector<Var> terms, std::vector<double> factors)
        : terms_(std::move(terms)),
          factors_(std::move(factors)),
          total_(tape.result("total", {1}, true)) {}

    std::string_view name() const override { return "weighted_sum"; }
    Var output() const override { return total_; }

    void forward(Tape<T>& tape) override {
        double total = 0;
        for (std::size_t j = 0; j < terms_.size(); ++j) {
            for (const T x : tape.value(terms_[j])) total += factors_[j] * static_cast<double>(x);
        }
        tape.value(total_)[0] = static_cast<T>(total);
    }

    void backward(Tape<T>& tape) override {
        for (std::size_t j = 0; j < terms_.size(); ++j) {
            for (T& g : tape.grad(terms_[j])) {
                g += static_cast<T>(factors_[j]) * tape.grad(total_)[0];
            }
        }
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        T total = 0;
        for (std::size_t j = 0; j < terms_.size(); ++j) {
            for (const T x : tape.value(terms_[j])) total += static_cast<T>(factors_[j]) * x;
        }
        return {total};
    }

  private:
    std::vector<Var> terms_;
    std::vector<double> factors_;
    Var total_;
};

template <class T>
class Tanh final : public Op<T> {
  public:
    Tanh(Tape<T>& tape, Var x) : x_(x), y_(tape.result("tanh", tape.extents(x), true)) {}

    std::string_view name() const override { return "tanh"; }
    Var output() const override { return y_; }

    void forward(Tape<T>& tape) override {
        const auto count = static_cast<std::int64_t>(tape.value(x_).size());
        const Chunks chunks{count, std::int64_t{1} << 14};
        parallel_for(chunks.count(), [&](std::int64_t i) {
            kernels<T>().tanh_forward(tape.value(x_).data() + chunks.begin(i),
                                      chunks.end(i) - chunks.begin(i),
                                      tape.value(y_).data() + chunks.begin(i));
        });
    }

    void backward(Tape<T>& tape) override {
        if (!tape.needs_grad(x_)) return;
        for (std::size_t i = 0; i < tape.value(y_).size(); ++i) {
            const T y = tape.value(y_)[i];
            tape.grad(x_)[i] += tape.grad(y_)[i] * (1 - y * y);
        }
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> y;
        for (const T x : tape.value(x_)) y.push_back(std::tanh(x));
        return y;
    }

  private:
    Var x_, y_;
};

}  // namespace

int lane_count(int shapes) { return shapes <= 8 ? 8 : (shapes + 15) / 16 * 16; }

template <class T>
Var squared_error(Tape<T>& tape, Var x, Var y, const LaneMask<T>& lanes) {
    return record_op<SquaredError<T>>(tape, x, y, lanes);
}

template <class T>
Var range_penalty(Tape<T>& tape, Var codes, double limit, const LaneMask<T>& lanes) {
    return record_op<RangePenalty<T>>(tape, codes, limit, lanes);
}

template <class T>
Var weighted_sum(Tape<T>& tape, std::vector<Var> terms, std::vector<double> factors) {
    return record_op<WeightedSum<T>>(tape, std::move(terms), std::move(factors));
}

template <class T>
Var tanh(Tape<T>& tape, Var x) {
    return record_op<Tanh<T>>(tape, x);
}

template Var squared_error(Tape<float>&, Var, Var, const LaneMask<float>&);
template Var squared_error(Tape<double>&, Var, Var, const LaneMask<double>&);
template Var range_penalty(Tape<float>&, Var, double, const LaneMask<float>&);
template Var range_penalty(Tape<double>&, Var, double, const LaneMask<double>&);
template Var weighted_sum(Tape<float>&, std::vector<Var>, std::vector<double>);
template Var weighted_sum(Tape<double>&, std::vector<Var>, std::vector<double>);
template Var tanh(Tape<float>&, Var);
template Var tanh(Tape<double>&, Var);

}  // namespace mscomp::nn

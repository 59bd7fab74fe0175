// SPDX-License-Identifier: MIT
// From one level to the next: masks from component weights, masked residuals as inputs of the
// children.
#include <cmath>
#include <span>
#include <vector>

#include "../kernels/kernels.h"
#include "batch.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "nn/ops.h"

namespace mscomp::nn {
namespace {

template <class T>
T squared_norm(const T* vector) {
    T sum = 0;
    for (int c = 0; c < kFeatureDim; ++c) sum += vector[c] * vector[c];
    return sum;
}

template <class T>
class AttentionMask final : public Op<T> {
  public:
    AttentionMask(Tape<T>& tape, Var weights, double power, double epsilon)
        : weights_(weights),
          power_(power),
          epsilon_(static_cast<T>(epsilon)),
          autoencoders_(tape.extents(weights)[0]),
          components_(tape.extents(weights)[1]),
          vertices_(tape.extents(weights)[2]),
          mask_(tape.result("attention_mask", {autoencoders_ * components_, vertices_}, true)) {}

    std::string_view name() const override { return "attention_mask"; }
    Var output() const override { return mask_; }

    void forward(Tape<T>& tape) override {
        const std::span<T> mask = tape.value(mask_);
        for_each_chunk(autoencoders_, vertices_, [&](std::int64_t a, std::int64_t, int b, int e) {
            const Columns columns(components_);
            for (int v = b; v < e; ++v) {
                shares(tape, a, v, columns.q);
                if (power_ != 1.0) sharpen(columns.q, columns.s);
                const std::span<T> column = power_ != 1.0 ? columns.s : columns.q;
                for (std::int64_t k = 0; k < components_; ++k) {
                    mask[mask_at(a, k, v)] = column[at(k)];
                }
            }
        });
    }

    void backward(Tape<T>& tape) override {
        for_each_chunk(autoencoders_, vertices_, [&](std::int64_t a, std::int64_t, int b, int e) {
            const Columns columns(components_);
            for (int v = b; v < e; ++v) {
                const T total = shares(tape, a, v, columns.q);
                for (std::int64_t k = 0; k < components_; ++k) {
                    columns.dq[at(k)] = tape.grad(mask_)[mask_at(a, k, v)];
                }
                if (power_ != 1.0) sharpen_backward(columns);
                add_share_gradients(tape, a, v, columns.q, columns.dq, total);
            }
        });
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> mask(tape.value(mask_).size());
        for (std::int64_t a = 0; a < autoencoders_; ++a) {
            for (std::int64_t v = 0; v < vertices_; ++v) {
                T total = 0, sharp_total = 0;
                const auto share = [&](std::int64_t k) {
                    return (squared_norm(&tape.value(weights_)[weights_at(a, k, v)]) + epsilon_) /
                           total;
                };
                const auto sharp = [&](std::int64_t k) {
                    return static_cast<T>(std::pow(share(k), power_)) + epsilon_;
                };
                for (std::int64_t k = 0; k < components_; ++k) {
                    total += squared_norm(&tape.value(weights_)[weights_at(a, k, v)]) + epsilon_;
                }
                for (std::int64_t k = 0; k < components_; ++k) sharp_total += sharp(k);
                for (std::int64_t k = 0; k < components_; ++k) {
                    mask[mask_at(a, k, v)] = power_ == 1.0 ? share(k) : sharp(k) / sharp_total;
                }
            }
        }
        return mask;
    }

  private:
    std::size_t weights_at(std::int64_t a, std::int64_t k, std::int64_t v) const {
        return at(((a * components_ + k) * vertices_ + v) * kFeatureDim);
    }
    std::size_t mask_at(std::int64_t a, std::int64_t k, std::int64_t v) const {
        return at((a * components_ + k) * vertices_ + v);
    }

    /// Memory of this thread for one vertex.
    struct Columns {
        std::span<T> q, s, dq;
        explicit Columns(std::int64_t components) {
            thread_local std::vector<T> memory;
            const auto count = at(components);
            if (memory.size() < 3 * count) memory.resize(3 * count);
            q = std::span<T>(memory).first(count);
            s = std::span<T>(memory).subspan(count, count);
            dq = std::span<T>(memory).subspan(2 * count, count);
        }
    };

    /// q_k = (a_k + e) / total; returns the total.
    T shares(Tape<T>& tape, std::int64_t a, std::int64_t v, std::span<T> q) const {
        T total = 0;
        for (std::int64_t k = 0; k < components_; ++k) {
            T& entry = q[at(k)];
            entry = squared_norm(&tape.value(weights_)[weights_at(a, k, v)]) + epsilon_;
            total += entry;
        }
        for (T& entry : q) entry /= total;
        return total;
    }

    /// x^power; whole powers by repeated squaring.
    T raised(T x, double power) const {
        constexpr double kLargestWhole = 64;
        if (power < 0 || power > kLargestWhole || power != std::floor(power)) {
            return static_cast<T>(std::pow(x, static_cast<T>(power)));
        }
        T result = 1;
        for (auto rest = static_cast<unsigned>(power); rest > 0; rest >>= 1) {
            if ((rest & 1U) != 0) result *= x;
            x *= x;
        }
        return result;
    }

    /// s_k = (q_k^p + e) / sum; returns the sum. Since the q sum to 1 the largest is at least 1/K:
    /// no power underflows all.
    T sharpen(std::span<const T> q, std::span<T> s) const {
        T total = 0;
        for (std::size_t k = 0; k < q.size(); ++k) {
            s[k] = raised(q[k], power_) + epsilon_;
            total += s[k];
        }
        for (T& entry : s) entry /= total;
        return total;
    }

    /// d/dq of sharpen in the place of d/ds; a power below 1 has no slope at 0 worth following, so
    /// q is kept from it.
    void sharpen_backward(const Columns& columns) const {
        const auto p = static_cast<T>(power_);
        const T total = sharpen(columns.q, columns.s);
        T inner = 0;
        for (std::size_t k = 0; k < columns.q.size(); ++k) inner += columns.s[k] * columns.dq[k];
        for (std::size_t k = 0; k < columns.q.size(); ++k) {
            const T q = columns.q[k];
            const T slope = q > 0 ? p * raised(q, power_ - 1) : T{0};
            columns.dq[k] = slope * (columns.dq[k] - inner) / total;
        }
    }

    /// da_k = (dq_k - sum_j q_j dq_j) / total, dC = 2 C da.
    void add_share_gradients(Tape<T>& tape, std::int64_t a, std::int64_t v, std::span<const T> q,
                             std::span<const T> dq, T total) const {
        T inner = 0;
        for (std::size_t k = 0; k < q.size(); ++k) inner += q[k] * dq[k];
        for (std::int64_t k = 0; k < components_; ++k) {
            const T da = (dq[at(k)] - inner) / total;
            const std::size_t place = weights_at(a, k, v);
            for (std::size_t c = 0; c < kFeatureDim; ++c) {
                tape.grad(weights_)[place + c] += 2 * tape.value(weights_)[place + c] * da;
            }
        }
    }

    Var weights_;
    double power_;
    T epsilon_;
    std::int64_t autoencoders_, components_, vertices_;
    Var mask_;
};

template <class T>
class MaskedResidual final : public Op<T> {
  public:
    MaskedResidual(Tape<T>& tape, Var x, Var y, Var mask, bool joint)
        : x_(x),
          y_(y),
          mask_(mask),
          parents_(tape.extents(x)[0]),
          children_(mask.valid() ? tape.extents(mask)[0] / parents_ : 1),
          vertices_(tape.extents(x)[1]),
          lanes_(static_cast<int>(tape.extents(x)[3])),
          out_(tape.result("masked_residual",
                           {parents_ * children_, vertices_, kFeatureDim, lanes_}, joint)) {}

    std::string_view name() const override { return "masked_residual"; }
    Var output() const override { return out_; }

    void forward(Tape<T>& tape) override {
        for_each_chunk(parents_ * children_, vertices_,
                       [&](std::int64_t child, std::int64_t, int b, int e) {
                           const std::int64_t parent = child / children_;
                           kernels<T>().masked_residual(tape.value(x_).data() + parent * rows(),
                                                        tape.value(y_).data() + parent * rows(),
                                                        mask_row(tape, child), lanes_, b, e,
                                                        tape.value(out_).data() + child * rows());
                       });
    }

    void backward(Tape<T>& tape) override {
        // One task owns the vertices of a parent and adds its children one after the other.
        for_each_chunk(parents_, vertices_, [&](std::int64_t parent, std::int64_t, int b, int e) {
            T* dx = tape.needs_grad(x_) ? tape.grad(x_).data() + parent * rows() : nullptr;
            T* dy = tape.needs_grad(y_) ? tape.grad(y_).data() + parent * rows() : nullptr;
            for (std::int64_t k = 0; k < children_; ++k) {
                const std::int64_t child = parent * children_ + k;
                T* dmask = mask_.valid() ? tape.grad(mask_).data() + child * vertices_ : nullptr;
                kernels<T>().masked_residual_backward(
                    tape.value(x_).data() + parent * rows(),
                    tape.value(y_).data() + parent * rows(), mask_row(tape, child),
                    tape.grad(out_).data() + child * rows(), lanes_, b, e, dx, dy, dmask);
            }
        });
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> out;
        for (std::int64_t child = 0; child < parents_ * children_; ++child) {
            for (std::int64_t i = 0; i < rows(); ++i) {
                const auto place = at(child / children_ * rows() + i);
                const std::int64_t v = i / (kFeatureDim * lanes_);
                const T weight = mask_.valid() ? mask_row(tape, child)[v] : T{1};
                out.push_back(weight * (tape.value(x_)[place] - tape.value(y_)[place]));
            }
        }
        return out;
    }

  private:
    std::int64_t rows() const { return vertices_ * kFeatureDim * lanes_; }
    const T* mask_row(Tape<T>& tape, std::int64_t child) const {
        return mask_.valid() ? tape.value(mask_).data() + child * vertices_ : nullptr;
    }

    Var x_, y_, mask_;
    std::int64_t parents_, children_, vertices_;
    int lanes_;
    Var out_;
};

}  // namespace

template <class T>
Var attention_mask(Tape<T>& tape, Var component_weights, double power, double epsilon) {
    return record_op<AttentionMask<T>>(tape, component_weights, power, epsilon);
}

template <class T>
Var masked_residual(Tape<T>& tape, Var x, Var y, Var mask, bool joint) {
    return record_op<MaskedResidual<T>>(tape, x, y, mask, joint);
}

template Var attention_mask(Tape<float>&, Var, double, double);
template Var attention_mask(Tape<double>&, Var, double, double);
template Var masked_residual(Tape<float>&, Var, Var, Var, bool);
template Var masked_residual(Tape<double>&, Var, Var, Var, bool);

}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "batch.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/nn/ops.h"

namespace mscomp::nn {
namespace {

template <class T>
T norm(const T* vector) {
    T sum = 0;
    for (int c = 0; c < kFeatureDim; ++c) sum += vector[c] * vector[c];
    return std::sqrt(sum);
}

template <class T>
class GroupSparsity final : public Op<T> {
  public:
    GroupSparsity(Tape<T>& tape, Var weights, DistanceRows& distances, SparsityRange range,
                  bool differentiable)
        : weights_(weights),
          distances_(distances),
          range_(range),
          autoencoders_(tape.extents(weights)[0]),
          components_(tape.extents(weights)[1]),
          vertices_(tape.extents(weights)[2]),
          omega_(tape.result("group_sparsity", {autoencoders_}, differentiable)) {
        lambda_rows_.resize(static_cast<std::size_t>(autoencoders_ * components_));
        row_sums_.resize(lambda_rows_.size());
    }

    std::string_view name() const override { return "group_sparsity"; }
    Var output() const override { return omega_; }

    void forward(Tape<T>& tape) override {
        const std::int64_t rows = autoencoders_ * components_;
        const std::vector<int> centers = component_centers<T>(
            tape.value(weights_), static_cast<int>(rows), static_cast<int>(vertices_));
        for (std::int64_t row = 0; row < rows; ++row) {
            lambda_rows_[static_cast<std::size_t>(row)] =
                distances_.row(centers[static_cast<std::size_t>(row)]);
        }
        parallel_for(rows, [&](std::int64_t row) {
            const T* c = tape.value(weights_).data() + row * vertices_ * kFeatureDim;
            double sum = 0;
            for (std::int64_t v = 0; v < vertices_; ++v) {
                const double lambda = weight(row, v);
                if (lambda > 0) sum += lambda * static_cast<double>(norm(c + v * kFeatureDim));
            }
            row_sums_[static_cast<std::size_t>(row)] = sum;
        });
        for (std::int64_t a = 0; a < autoencoders_; ++a) {
            double sum = 0;
            for (std::int64_t k = 0; k < components_; ++k) {
                sum += row_sums_[static_cast<std::size_t>(a * components_ + k)];
            }
            tape.value(omega_)[static_cast<std::size_t>(a)] =
                static_cast<T>(sum / static_cast<double>(components_));
        }
    }

    void backward(Tape<T>& tape) override {
        parallel_for(autoencoders_ * components_, [&](std::int64_t row) {
            const T* c = tape.value(weights_).data() + row * vertices_ * kFeatureDim;
            T* dc = tape.grad(weights_).data() + row * vertices_ * kFeatureDim;
            const double factor = static_cast<double>(tape.grad(
                                      omega_)[static_cast<std::size_t>(row / components_)]) /
                                  static_cast<double>(components_);
            for (std::int64_t v = 0; v < vertices_; ++v) {
                const double lambda = weight(row, v);
                const T length = norm(c + v * kFeatureDim);
                if (!(lambda > 0) || length == T{0}) continue;
                const T scale = static_cast<T>(factor * lambda) / length;
                for (int i = 0; i < kFeatureDim; ++i) {
                    dc[v * kFeatureDim + i] += scale * c[v * kFeatureDim + i];
                }
            }
        });
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> omega(static_cast<std::size_t>(autoencoders_), T{0});
        for (std::int64_t row = 0; row < autoencoders_ * components_; ++row) {
            const T* c = tape.value(weights_).data() + row * vertices_ * kFeatureDim;
            int center = 0;
            for (int v = 1; v < vertices_; ++v) {
                if (norm(c + v * kFeatureDim) > norm(c + center * kFeatureDim)) center = v;
            }
            for (int v = 0; v < vertices_; ++v) {
                const double d = distances_.row(center)[static_cast<std::size_t>(v)];
                omega[static_cast<std::size_t>(row / components_)] +=
                    static_cast<T>(range_.weight(d)) * norm(c + v * kFeatureDim) /
                    static_cast<T>(components_);
            }
        }
        return omega;
    }

  private:
    double weight(std::int64_t row, std::int64_t v) const {
        return range_.weight(
            lambda_rows_[static_cast<std::size_t>(row)][static_cast<std::size_t>(v)]);
    }

    Var weights_;
    DistanceRows& distances_;
    SparsityRange range_;
    std::int64_t autoencoders_, components_, vertices_;
    Var omega_;
    std::vector<std::span<const double>> lambda_rows_;  // distances from each centre
    std::vector<double> row_sums_;
};

}  // namespace

double SparsityRange::weight(double distance) const {
    if (!ramp) return distance >= range ? 1.0 : 0.0;
    return std::clamp((distance - ramp->from) / (ramp->to - ramp->from), 0.0, 1.0);
}

template <class T>
std::vector<int> component_centers(std::span<const T> component_weights, int rows,
                                   int vertex_count) {
    std::vector<int> centers(static_cast<std::size_t>(rows), 0);
    parallel_for(rows, [&](std::int64_t row) {
        const T* c = component_weights.data() + row * vertex_count * kFeatureDim;
        T largest = -1;
        for (int v = 0; v < vertex_count; ++v) {
            T length = 0;
            for (int i = 0; i < kFeatureDim; ++i) {
                length += c[v * kFeatureDim + i] * c[v * kFeatureDim + i];
            }
            if (length > largest) {
                largest = length;
                centers[static_cast<std::size_t>(row)] = v;
            }
        }
    });
    return centers;
}

template <class T>
Var group_sparsity(Tape<T>& tape, Var component_weights, DistanceRows& distances,
                   SparsityRange range, bool differentiable) {
    return record_op<GroupSparsity<T>>(tape, component_weights, distances, range, differentiable);
}

template std::vector<int> component_centers(std::span<const float>, int, int);
template std::vector<int> component_centers(std::span<const double>, int, int);
template Var group_sparsity(Tape<float>&, Var, DistanceRows&, SparsityRange, bool);
template Var group_sparsity(Tape<double>&, Var, DistanceRows&, SparsityRange, bool);

}  // namespace mscomp::nn

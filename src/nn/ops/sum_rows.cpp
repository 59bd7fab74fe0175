// SPDX-License-Identifier: MIT
#include <algorithm>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "batch.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "nn/ops.h"

namespace mscomp::nn {
namespace {

template <class T>
class SumRows final : public Op<T> {
  public:
    SumRows(Tape<T>& tape, std::vector<Var> rows, bool joint)
        : rows_(std::move(rows)),
          joint_(joint),
          vertices_(tape.extents(rows_.front())[1]),
          row_(std::int64_t{kFeatureDim} * tape.extents(rows_.front())[3]),
          sum_(tape.result("sum_rows", {1, vertices_, kFeatureDim, row_ / kFeatureDim}, true)) {}

    std::string_view name() const override { return "sum_rows"; }
    Var output() const override { return sum_; }

    void forward(Tape<T>& tape) override {
        for_each_chunk(1, vertices_, [&](std::int64_t, std::int64_t, int b, int e) {
            T* sum = tape.value(sum_).data();
            std::fill(sum + b * row_, sum + e * row_, T{0});
            for (const Var rows : rows_) {
                for (std::int64_t a = 0; a < tape.extents(rows)[0]; ++a) {
                    const T* from = tape.value(rows).data() + a * vertices_ * row_;
                    for (std::int64_t i = b * row_; i < e * row_; ++i) sum[i] += from[i];
                }
            }
        });
    }

    void backward(Tape<T>& tape) override {
        const T* from = tape.grad(sum_).data();
        for (const Var rows : rows_) {
            const bool is_stopped = !joint_ && rows.index != rows_.back().index;
            if (is_stopped || !tape.needs_grad(rows)) continue;
            for_each_chunk(tape.extents(rows)[0], vertices_,
                           [&](std::int64_t a, std::int64_t, int b, int e) {
                               T* to = tape.grad(rows).data() + a * vertices_ * row_;
                               for (std::int64_t i = b * row_; i < e * row_; ++i) to[i] += from[i];
                           });
        }
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        std::vector<T> sum(at(vertices_ * row_), T{0});
        for (const Var rows : rows_) {
            const std::span<T> values = tape.value(rows);
            for (std::size_t i = 0; i < values.size(); ++i) sum[i % sum.size()] += values[i];
        }
        return sum;
    }

  private:
    std::vector<Var> rows_;
    bool joint_;
    std::int64_t vertices_, row_;
    Var sum_;
};

}  // namespace

template <class T>
Var sum_rows(Tape<T>& tape, std::vector<Var> rows, bool joint) {
    return record_op<SumRows<T>>(tape, std::move(rows), joint);
}

template Var sum_rows(Tape<float>&, std::vector<Var>, bool);
template Var sum_rows(Tape<double>&, std::vector<Var>, bool);

}  // namespace mscomp::nn

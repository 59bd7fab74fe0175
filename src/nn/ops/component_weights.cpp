// SPDX-License-Identifier: MIT
// The fully connected layers: project (encoder) and expand (decoder), which share C.
#include "../kernels/kernels.h"
#include "batch.h"
#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "nn/ops.h"

namespace mscomp::nn {
namespace {

/// Sizes shared by both directions.
struct Layer {
    std::int64_t autoencoders, vertices;
    int components, lanes;

    std::int64_t rows() const { return vertices * kFeatureDim * lanes; }
    std::int64_t stride() const { return vertices * kFeatureDim; }
    std::int64_t weights() const { return components * stride(); }
    std::int64_t codes() const { return std::int64_t{components} * lanes; }
};

/// codes (A,K,lanes) += C rows, through partial sums per vertex chunk.
template <class T>
void add_projection(const Layer& layer, const T* weights, const T* rows, AlignedVector<T>& partials,
                    T* codes) {
    const std::int64_t chunks = chunk_count(layer.vertices);
    partials.assign(at(layer.autoencoders * chunks * layer.codes()), T{0});
    for_each_chunk(layer.autoencoders, layer.vertices,
                   [&](std::int64_t a, std::int64_t chunk, int begin, int end) {
                       kernels<T>().project(weights + a * layer.weights(), layer.stride(),
                                            layer.components, rows + a * layer.rows(), layer.lanes,
                                            begin, end,
                                            partials.data() + (a * chunks + chunk) * layer.codes());
                   });
    parallel_for(layer.autoencoders, [&](std::int64_t a) {
        add_partials(partials.data() + a * chunks * layer.codes(), chunks, layer.codes(),
                     codes + a * layer.codes());
    });
}

template <class T>
void expand_rows(const Layer& layer, const T* weights, const T* codes, bool accumulate, T* rows) {
    for_each_chunk(layer.autoencoders, layer.vertices,
                   [&](std::int64_t a, std::int64_t, int begin, int end) {
                       kernels<T>().expand(weights + a * layer.weights(), layer.stride(),
                                           layer.components, codes + a * layer.codes(), layer.lanes,
                                           begin, end, accumulate, rows + a * layer.rows());
                   });
}

template <class T>
void add_outer(const Layer& layer, const T* codes, const T* rows, T* weights_grad) {
    for_each_chunk(layer.autoencoders, layer.vertices,
                   [&](std::int64_t a, std::int64_t, int begin, int end) {
                       kernels<T>().outer(codes + a * layer.codes(), rows + a * layer.rows(),
                                          layer.stride(), layer.components, layer.lanes, begin, end,
                                          weights_grad + a * layer.weights());
                   });
}

template <class T>
class Project final : public Op<T> {
  public:
    Project(Tape<T>& tape, Var rows, Var weights)
        : layer_{tape.extents(rows)[0], tape.extents(rows)[1],
                 static_cast<int>(tape.extents(weights)[1]),
                 static_cast<int>(tape.extents(rows)[3])},
          rows_(rows),
          weights_(weights),
          codes_(
              tape.result("codes", {layer_.autoencoders, layer_.components, layer_.lanes}, true)) {}

    std::string_view name() const override { return "project"; }
    Var output() const override { return codes_; }

    void forward(Tape<T>& tape) override {
        const std::span<T> codes = tape.value(codes_);
        std::fill(codes.begin(), codes.end(), T{0});
        add_projection(layer_, tape.value(weights_).data(), tape.value(rows_).data(), partials_,
                       codes.data());
    }

    void backward(Tape<T>& tape) override {
        const T* dcodes = tape.grad(codes_).data();
        add_outer(layer_, dcodes, tape.value(rows_).data(), tape.grad(weights_).data());
        if (!tape.needs_grad(rows_)) return;
        expand_rows(layer_, tape.value(weights_).data(), dcodes, true, tape.grad(rows_).data());
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        const std::span<T> rows = tape.value(rows_), weights = tape.value(weights_);
        std::vector<T> codes;
        for (std::int64_t a = 0; a < layer_.autoencoders; ++a) {
            for (int k = 0; k < layer_.components; ++k) {
                for (int l = 0; l < layer_.lanes; ++l) {
                    T sum = 0;
                    for (std::int64_t i = 0; i < layer_.stride(); ++i) {
                        sum += weights[at(a * layer_.weights() + k * layer_.stride() + i)] *
                               rows[at(a * layer_.rows() + i * layer_.lanes + l)];
                    }
                    codes.push_back(sum);
                }
            }
        }
        return codes;
    }

  private:
    Layer layer_;
    Var rows_, weights_, codes_;
    AlignedVector<T> partials_;
};

template <class T>
class Expand final : public Op<T> {
  public:
    Expand(Tape<T>& tape, Var codes, Var weights)
        : layer_{tape.extents(weights)[0], tape.extents(weights)[2],
                 static_cast<int>(tape.extents(weights)[1]),
                 static_cast<int>(tape.extents(codes)[2])},
          codes_(codes),
          weights_(weights),
          rows_(tape.result("expanded",
                            {layer_.autoencoders, layer_.vertices, kFeatureDim, layer_.lanes},
                            true)) {}

    std::string_view name() const override { return "expand"; }
    Var output() const override { return rows_; }

    void forward(Tape<T>& tape) override {
        expand_rows(layer_, tape.value(weights_).data(), tape.value(codes_).data(), false,
                    tape.value(rows_).data());
    }

    void backward(Tape<T>& tape) override {
        const T* drows = tape.grad(rows_).data();
        add_outer(layer_, tape.value(codes_).data(), drows, tape.grad(weights_).data());
        if (!tape.needs_grad(codes_)) return;
        add_projection(layer_, tape.value(weights_).data(), drows, partials_,
                       tape.grad(codes_).data());
    }

    std::vector<T> reference(Tape<T>& tape) const override {
        const std::span<T> codes = tape.value(codes_), weights = tape.value(weights_);
        std::vector<T> rows;
        for (std::int64_t a = 0; a < layer_.autoencoders; ++a) {
            for (std::int64_t i = 0; i < layer_.stride(); ++i) {
                for (int l = 0; l < layer_.lanes; ++l) {
                    T sum = 0;
                    for (int k = 0; k < layer_.components; ++k) {
                        sum += weights[at(a * layer_.weights() + k * layer_.stride() + i)] *
                               codes[at(a * layer_.codes() + k * layer_.lanes + l)];
                    }
                    rows.push_back(sum);
                }
            }
        }
        return rows;
    }

  private:
    Layer layer_;
    Var codes_, weights_, rows_;
    AlignedVector<T> partials_;
};

}  // namespace

template <class T>
Var project(Tape<T>& tape, Var rows, Var component_weights) {
    return record_op<Project<T>>(tape, rows, component_weights);
}

template <class T>
Var expand(Tape<T>& tape, Var codes, Var component_weights) {
    return record_op<Expand<T>>(tape, codes, component_weights);
}

template Var project(Tape<float>&, Var, Var);
template Var project(Tape<double>&, Var, Var);
template Var expand(Tape<float>&, Var, Var);
template Var expand(Tape<double>&, Var, Var);

}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
#include "nn/tape.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp::nn {
namespace {

constexpr std::int64_t kFillChunk = std::int64_t{1} << 18;

template <class T>
void fill_zero(std::span<T> values) {
    const Chunks chunks{static_cast<std::int64_t>(values.size()), kFillChunk};
    parallel_for(chunks.count(), [&](std::int64_t i) {
        std::fill(values.begin() + chunks.begin(i), values.begin() + chunks.end(i), T{0});
    });
}

}  // namespace

template <class T>
Var Tape<T>::input(std::string name, Extents extents, bool needs_grad) {
    return result(std::move(name), std::move(extents), needs_grad);
}

template <class T>
Var Tape<T>::parameter(ParameterSet<T>& parameters, int index) {
    auto made = std::make_unique<Node>();
    made->name = parameters.entry(index).name;
    made->extents = parameters.entry(index).extents;
    made->needs_grad = true;
    made->value = parameters.value(index);
    made->grad = parameters.grad(index);
    nodes_.push_back(std::move(made));
    return {static_cast<int>(nodes_.size()) - 1};
}

template <class T>
Var Tape<T>::result(std::string name, Extents extents, bool needs_grad) {
    auto made = std::make_unique<Node>();
    made->name = std::move(name);
    made->extents = std::move(extents);
    made->needs_grad = needs_grad;
    const auto count = at(element_count(made->extents));
    made->own_value.resize(count);
    made->value = made->own_value;
    if (needs_grad) {
        made->own_grad.resize(count);
        made->grad = made->own_grad;
    }
    nodes_.push_back(std::move(made));
    return {static_cast<int>(nodes_.size()) - 1};
}

template <class T>
void Tape<T>::forward() {
    for (const auto& op : ops_) op->forward(*this);
}

template <class T>
void Tape<T>::backward(Var root) {
    for (const auto& each : nodes_) fill_zero(std::span<T>(each->own_grad));
    grad(root)[0] = T{1};
    for (auto op = ops_.rbegin(); op != ops_.rend(); ++op) {
        if (needs_grad((*op)->output())) (*op)->backward(*this);
    }
}

template <class T>
const Op<T>* Tape<T>::first_non_finite() {
    for (const auto& op : ops_) {
        for (const T x : value(op->output())) {
            if (!std::isfinite(x)) return op.get();
        }
    }
    return nullptr;
}

template <class T>
std::span<T> Tape<T>::scratch(std::int64_t count) {
    if (at(count) > scratch_.size()) {
        scratch_.resize(at(count));
    }
    return std::span<T>(scratch_).first(at(count));
}

template class Tape<float>;
template class Tape<double>;

}  // namespace mscomp::nn

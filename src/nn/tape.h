// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/aligned.h"
#include "mscomp/base/index.h"
#include "nn/parameter_set.h"

namespace mscomp::nn {

/// A value on a tape: an index, never a pointer.
struct Var {
    int index = -1;
    bool valid() const { return index >= 0; }
};

template <class T>
class Tape;

/// A coarse tensor operation with hand-written kernels. forward fills its outputs; backward adds to
/// the gradients of its inputs, and leaves alone those that need none; it comes at most once after
/// each forward, since it may use up what forward left.
template <class T>
class Op {
  public:
    Op() = default;
    Op(const Op&) = delete;
    Op& operator=(const Op&) = delete;
    virtual ~Op() = default;

    virtual std::string_view name() const = 0;
    virtual Var output() const = 0;
    virtual void forward(Tape<T>& tape) = 0;
    virtual void backward(Tape<T>& tape) = 0;
    /// What forward has to give, computed as naively as the formula reads; for tests and
    /// benchmarks.
    virtual std::vector<T> reference(Tape<T>& tape) const = 0;
};

/// Values, gradients and the ops that connect them, in the order they were recorded, which is
/// topological. Recorded once and run every step, so that a step allocates nothing.
template <class T>
class Tape {
  public:
    Tape() = default;
    Tape(const Tape&) = delete;
    Tape& operator=(const Tape&) = delete;

    /// A value that the caller fills before each run.
    Var input(std::string name, Extents extents, bool needs_grad = false);
    /// A parameter; value and gradient live in `parameters`, which must outlive the tape and get no
    /// further entries.
    Var parameter(ParameterSet<T>& parameters, int index);
    /// The result of the op about to be recorded.
    Var result(std::string name, Extents extents, bool needs_grad);
    void record(std::unique_ptr<Op<T>> op) { ops_.push_back(std::move(op)); }

    std::span<T> value(Var var) { return node(var).value; }
    std::span<T> grad(Var var) { return node(var).grad; }  // empty where none is needed
    bool needs_grad(Var var) const { return node(var).needs_grad; }
    const Extents& extents(Var var) const { return node(var).extents; }
    const std::string& name(Var var) const { return node(var).name; }

    void forward();
    /// Zeroes the gradients of everything but parameters (ParameterSet::zero_grad is the caller's),
    /// then accumulates d(root)/d(everything); `root` has one element.
    void backward(Var root);

    std::span<const std::unique_ptr<Op<T>>> ops() const { return ops_; }
    /// The first op whose output is not finite, null if all are.
    const Op<T>* first_non_finite();
    /// Memory for short-lived results inside an op, at least `count` elements; one at a time.
    std::span<T> scratch(std::int64_t count);

  private:
    struct Node {
        std::string name;
        Extents extents;
        bool needs_grad = false;
        AlignedVector<T> own_value, own_grad;
        std::span<T> value, grad;
    };
    Node& node(Var var) { return *nodes_[at(var.index)]; }
    const Node& node(Var var) const { return *nodes_[at(var.index)]; }

    std::vector<std::unique_ptr<Node>> nodes_;
    std::vector<std::unique_ptr<Op<T>>> ops_;
    AlignedVector<T> scratch_;
};

}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "nn/fused.h"
#include "nn/ops.h"
#include "nn/spectral_ops.h"

namespace mscomp::nn {

/// Distances along a line of vertices: |i - j| / (V - 1).
class LineDistances final : public DistanceRows {
  public:
    explicit LineDistances(int vertices);
    int vertex_count() const override { return static_cast<int>(rows_.size()); }
    std::span<const double> row(int vertex) override {
        return rows_[static_cast<std::size_t>(vertex)];
    }

  private:
    std::vector<std::vector<double>> rows_;
};

/// A tape with one op on random inputs; keeps alive what the op borrows.
template <class T>
struct OpFixture {
    std::unique_ptr<RingTable<T>> rings;
    std::unique_ptr<LineDistances> distances;
    std::unique_ptr<SparsityRows> sparsity;
    std::unique_ptr<LevelSupports> supports;
    std::unique_ptr<ScaledLaplacian<T>> laplacian;
    std::unique_ptr<ComponentCenters<T>> centers;
    std::unique_ptr<BatchTerms<T>> terms;
    LaneMask<T> lanes;
    Tape<T> tape;
    std::vector<Var> inputs;  // all that the op gives a gradient
    Var output;
    std::vector<Var> further_outputs;  // of an op that has several
};

template <class T>
struct OpCase {
    std::string name;
    std::function<void(OpFixture<T>&)> build;
    std::size_t samples = 40;      // elements to check of each input of a wide fixture
    double rounded_terms = 7 * 9;  // bound of float against double, see FloatOps
    friend void PrintTo(const OpCase& op_case, std::ostream* out) { *out << op_case.name; }
};

/// The one table every op stands in: gradients, references and instruction sets are checked over
/// it.
template <class T>
std::vector<OpCase<T>> op_table();
/// Its parts: the ops of the stacked model, those of the spectral VAE.
template <class T>
std::vector<OpCase<T>> stacked_op_table();
template <class T>
std::vector<OpCase<T>> spectral_op_table();

enum class FixtureSize {
    narrow,  // 13 vertices and 8 lanes, 5 of them active: every element can be checked
    wide     // 290 vertices, so three chunks of them, and 48 lanes, 37 of them active
};

/// The fixture of a case; one of the vertices is in no face.
template <class T>
std::unique_ptr<OpFixture<T>> make_fixture(const OpCase<T>& op_case,
                                           FixtureSize size = FixtureSize::narrow);

}  // namespace mscomp::nn

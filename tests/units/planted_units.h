// SPDX-License-Identifier: MIT
// Shapes made of units that switch on and off.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/random.h"
#include "mscomp/base/shape_features.h"
#include "mscomp/model/learned_model.h"

namespace mscomp::cases {

/// Codes (shapes,units) from 0 to 1, each unit on in about one shape of four.
inline Eigen::MatrixXd switching_codes(int shapes, int units) {
    const CounterRandom is_on(3, 1), how_much(3, 2);
    Eigen::MatrixXd codes(shapes, units);
    for (Eigen::Index i = 0; i < codes.size(); ++i) {
        const auto n = static_cast<std::uint64_t>(i);
        codes.data()[i] = is_on.uniform(n) < 0.25 ? 0.3 + 0.7 * how_much.uniform(n) : 0.0;
    }
    return codes;
}

/// For each column of `wanted` the |cosine| of the nearest column of `found`.
inline Eigen::VectorXd nearest_cosines(const Eigen::MatrixXd& wanted,
                                       const Eigen::MatrixXd& found) {
    return (wanted.colwise().normalized().transpose() * found.colwise().normalized())
        .cwiseAbs()
        .rowwise()
        .maxCoeff();
}

/// Features (shapes,V,9) in memory.
class Features final : public ShapeSet {
  public:
    Features(int vertices, const Eigen::MatrixXd& changes) : vertices_(vertices) {
        for (Eigen::Index i = 0; i < changes.size(); ++i) {
            values_.push_back(kReferenceFeature[at(i) % kFeatureDim] +
                              static_cast<float>(changes.data()[i]));
        }
    }
    int shape_count() const override { return static_cast<int>(values_.size()) / (9 * vertices_); }
    int vertex_count() const override { return vertices_; }
    std::span<const float> shape(int index) const override {
        return std::span(values_).subspan(9 * at(index * vertices_), 9 * at(vertices_));
    }
    std::span<const float> vertices(int) const override { return {}; }
    void forget(int) const override {}

  private:
    int vertices_;
    std::vector<float> values_;
};

inline Eigen::MatrixXd matrix_of(const CodeTable& table) {
    return Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
               table.values.data(), table.shape_count(), table.code_count)
        .cast<double>();
}

/// A learner that has begun with all shapes.
inline std::unique_ptr<Learner> started(LearnedModel& model, const ShapeSet& shapes) {
    std::vector<int> train(at(shapes.shape_count()));
    std::iota(train.begin(), train.end(), 0);
    auto learner = model.learner(shapes, train);
    learner->start();
    return learner;
}

}  // namespace mscomp::cases

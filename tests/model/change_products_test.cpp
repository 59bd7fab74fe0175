// SPDX-License-Identifier: MIT
#include "model/change_products.h"

#include <gtest/gtest.h>

#include "linear_model.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Components that move codes from -1 to 2 along the columns of `changes`.
std::vector<Component> moving(const MatrixXd& changes) {
    std::vector<Component> components;
    for (Index k = 0; k < changes.cols(); ++k) {
        Component& c = components.emplace_back();
        c.code = static_cast<int>(k);
        c.code_end = 2;
        c.code_other = -1;
        const Eigen::VectorXf end = (2 * changes.col(k)).cast<float>(),
                              other = (-changes.col(k)).cast<float>();
        c.difference.assign(end.begin(), end.end());
        c.other_difference.assign(other.begin(), other.end());
    }
    return components;
}

// Per unit of code, as the metric scales channels and vertices; a component that moves nothing, or
// whose code stays, has none.
TEST(ChangeProducts, AreInnerProductsInTheMetric) {
    const int vertices = 1500;
    MatrixXd changes = cases::normal_numbers(9 * vertices, 4, 1);
    changes.col(1).head(9 * 700).setZero();
    changes.col(2).setZero();
    std::vector<Component> components = moving(changes);
    components[3].code_end = components[3].code_other;
    MetricScale metric;
    for (std::size_t c = 0; c < 9; ++c) metric.factor[c] = 0.5 + static_cast<double>(c);
    for (int v = 0; v < vertices; ++v) metric.roots.push_back(1 + 0.001F * static_cast<float>(v));
    MatrixXd scaled = changes;
    scaled.col(3).setZero();
    for (Index i = 0; i < scaled.rows(); ++i) {
        scaled.row(i) *=
            metric.scale_factor(static_cast<std::size_t>(i / 9), static_cast<std::size_t>(i % 9));
    }
    const MatrixXd wanted = scaled.transpose() * scaled;
    EXPECT_LT((change_products(components, 9, &metric) - wanted).norm(), 1e-6 * wanted.norm());
    scaled = changes;
    scaled.col(3).setZero();
    const MatrixXd plain = scaled.transpose() * scaled;
    EXPECT_LT((change_products(components, 9, nullptr) - plain).norm(), 1e-6 * plain.norm());
}

TEST(ChangeProducts, ThreadsDoNotChangeABit) {
    const auto components = moving(cases::normal_numbers(9 * 5000, 6, 2));
    const int before = thread_count();
    set_thread_count(1);
    const MatrixXd one = change_products(components, 9, nullptr);
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        EXPECT_EQ(change_products(components, 9, nullptr), one);
    }
    set_thread_count(before);
}

}  // namespace
}  // namespace mscomp

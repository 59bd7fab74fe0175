// SPDX-License-Identifier: MIT
#include "multiscale/component_gradient.h"

#include <gtest/gtest.h>

#include "ball_cases.h"
#include "multiscale/space_error.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;

/// Components moved by `step` along a random direction, which is the same for all steps.
BallComponents moved(BallComponents components, double step) {
    const CounterRandom random(12, 0);
    for (std::size_t i = 0; i < components.all_values().size(); ++i) {
        components.all_values()[i] += static_cast<float>(step * random.normal(i));
    }
    return components;
}

/// The derivative along that direction.
double along(const std::vector<float>& gradient) {
    const CounterRandom random(12, 0);
    double sum = 0;
    for (std::size_t i = 0; i < gradient.size(); ++i) {
        sum += static_cast<double>(gradient[i]) * random.normal(i);
    }
    return sum;
}

// Against differences of F, whose codes follow the components.
TEST(ComponentGradient, OfFeaturesIsThatOfDifferences) {
    cases::Sphere sphere;
    const BallComponents components = sphere.components(10, 0.3);
    const MetricRows rows = cases::rows_of(cases::random_matrix(9 * sphere.vertices(), 6, 1));
    std::vector<float> gradient(components.all_values().size(), 7.0F), other(gradient);
    const double value = feature_error(rows, components, gradient);
    constexpr double kStep = 2e-4;
    const double slope = (feature_error(rows, moved(components, kStep), other) -
                          feature_error(rows, moved(components, -kStep), other)) /
                         (2 * kStep);
    EXPECT_NEAR(along(gradient), slope, 1e-4 * std::abs(slope));
    EXPECT_LT(value, cases::random_matrix(9 * sphere.vertices(), 6, 1).squaredNorm() / 6);
}

// Against differences of mean E at fixed codes.
TEST(ComponentGradient, InSpaceIsThatOfDifferences) {
    cases::Sphere sphere;
    const BallComponents components = sphere.components(10, 0.3);
    const MatrixXd codes = 2 * cases::random_matrix(10, 4, 5);
    const MetricRows rows =
        cases::rows_of(cases::dense(components) * (codes + cases::random_matrix(10, 4, 6)));
    const SpaceError error(sphere.mesh, "cotangent", sphere.scale, rows);
    MetricRows by_row(sphere.vertices(), 4);
    const auto mean = [&](const BallComponents& of) {
        double sum = 0;
        for (const double e : error.evaluate(of, codes, &by_row)) sum += e / 4;
        return sum;
    };
    constexpr double kStep = 1e-3;
    const double slope =
        (mean(moved(components, kStep)) - mean(moved(components, -kStep))) / (2 * kStep);
    mean(components);
    std::vector<float> gradient(components.all_values().size(), 0.0F);
    add_component_gradient(components, codes, by_row, 0.25, gradient);
    EXPECT_NEAR(along(gradient), slope, 1e-3 * std::abs(slope));
}

}  // namespace
}  // namespace mscomp

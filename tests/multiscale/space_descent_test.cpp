// SPDX-License-Identifier: MIT
#include "multiscale/space_descent.h"

#include <gtest/gtest.h>

#include "ball_cases.h"

namespace mscomp {
namespace {

/// Components a little beside those that the shapes are made of.
struct Beside {
    cases::Sphere sphere;
    BallComponents components = sphere.components(8, 0.3);
    MetricRows rows =
        cases::rows_of(cases::dense(components) * (2 * cases::random_matrix(8, 12, 5)));
    SpaceDescent descent{sphere.mesh, "cotangent", sphere.scale, rows, 0.3};

    Beside() {
        const CounterRandom random(8, 1);
        for (std::size_t i = 0; i < components.all_values().size(); ++i) {
            components.all_values()[i] += static_cast<float>(0.02 * random.normal(i));
        }
    }
};

TEST(SpaceDescent, LowersTheErrorInSpace) {
    Beside problem;
    SpaceState state = problem.descent.begin(problem.components);
    const double first = problem.descent.run_epoch(1, problem.components, state).space;
    double last = first;
    for (int epoch = 0; epoch < 4; ++epoch) {
        last = problem.descent.run_epoch(1, problem.components, state).space;
    }
    EXPECT_LT(last, 0.5 * first);
    EXPECT_EQ(state.steps, 5 * SpaceDescent::kSteps);
}

// What the features count holds them: they come out better where they count more.
TEST(SpaceDescent, TheShareOfFeaturesHoldsThem) {
    const auto features_with = [](double share) {
        Beside problem;
        const SpaceDescent descent(problem.sphere.mesh, "cotangent", problem.sphere.scale,
                                   problem.rows, share);
        SpaceState state = descent.begin(problem.components);
        for (int epoch = 0; epoch < 3; ++epoch) descent.run_epoch(1, problem.components, state);
        return descent.run_epoch(0, problem.components, state).features;
    };
    EXPECT_LT(features_with(100), 0.7 * features_with(0));
}

// The term of features alone, at rate 0: what it reports is the error of joint codes.
TEST(SpaceDescent, AtRateZeroComponentsStay) {
    Beside problem;
    SpaceState state = problem.descent.begin(problem.components);
    const Eigen::MatrixXd before = cases::dense(problem.components);
    const double first = problem.descent.run_epoch(0, problem.components, state).space;
    const double second = problem.descent.run_epoch(0, problem.components, state).space;
    EXPECT_TRUE(cases::dense(problem.components) == before);
    EXPECT_LT(second, first);  // codes follow all the same
}

}  // namespace
}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "multiscale/cross_validation.h"

#include <gtest/gtest.h>

#include "ball_cases.h"

namespace mscomp {
namespace {

// Shapes that one global direction makes up: with a global component left-out shapes come back,
// without one a few small balls cannot follow.
TEST(CrossValidation, TakesWhatHelpsShapesThatWereLeftOut) {
    cases::Sphere sphere;
    const Eigen::MatrixXd direction = cases::random_matrix(9 * sphere.vertices(), 1, 3);
    std::vector<float> features;
    std::vector<int> train;
    for (int m = 0; m < 9; ++m) {
        train.push_back(m);
        for (Eigen::Index i = 0; i < direction.size(); ++i) {
            features.push_back(kReferenceFeature[at(i) % kFeatureDim] +
                               static_cast<float>(0.02 * (m - 4) * direction(i)));
        }
    }
    const MemoryFeatures memory(features, sphere.vertices());
    MultiscaleSettings settings;
    settings.levels = {{3, 0.1, 0.1}};
    settings.rounds = 8;
    const std::string weights = "cotangent";
    const ChoicePlace place{sphere.mesh, weights, sphere.distances, sphere.scale, nullptr};
    const Choices with{1, 0}, without{0, 0};
    for (const std::vector<Choices>& order : {std::vector{with, without}, {without, with}}) {
        const ChosenBySpaceError best = choose(order, settings, 0, place, memory, train);
        EXPECT_EQ(best.choices, with);
        ASSERT_EQ(best.notes.size(), 2U);
    }
}

}  // namespace
}  // namespace mscomp

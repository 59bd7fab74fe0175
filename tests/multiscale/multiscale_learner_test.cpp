// SPDX-License-Identifier: MIT
#include "multiscale/multiscale_learner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "ball_cases.h"
#include "mscomp/model/divergence.h"
#include "mscomp/model/given_components.h"
#include "multiscale/code_columns.h"

namespace mscomp {
namespace {

/// Shapes whose features are noise, of which few components explain little.
class RoughShapes final : public ShapeSet {
  public:
    RoughShapes(int vertices, int shapes, double size) : vertices_(vertices) {
        const Eigen::MatrixXd random = size * cases::random_matrix(9 * vertices, shapes, 4);
        for (Eigen::Index i = 0; i < random.size(); ++i) {
            features_.push_back(kReferenceFeature[at(i) % kFeatureDim] +
                                static_cast<float>(random.data()[i]));
        }
    }
    int shape_count() const override { return static_cast<int>(features_.size()) / 9 / vertices_; }
    int vertex_count() const override { return vertices_; }
    std::span<const float> shape(int index) const override {
        return std::span(features_).subspan(9 * at(index * vertices_), 9 * at(vertices_));
    }
    std::span<const float> vertices(int) const override { return {}; }
    void forget(int) const override {}

  private:
    int vertices_;
    std::vector<float> features_;
};

/// Two global components and levels as they are given, nothing chosen and nothing mixed.
Config fitted_by(std::vector<BallLevel> levels, int rounds, int epochs) {
    Config config;
    MultiscaleSettings settings;
    settings.global_components = 2;
    settings.levels = std::move(levels);
    settings.rounds = rounds;
    settings.select = false;
    config.settings = settings;
    config.train.epochs = epochs;
    config.train.fill_up_to = 0;
    return config;
}

// However little the first stage explains, the second ends: what goes astray is undone at half the
// rate as often as a run does that, and the error in space falls.
TEST(MultiscaleLearner, ComesThroughSpaceWhereLittleIsExplained) {
    for (const int levels : {1, 2}) {
        for (const double size : {0.02, 0.1, 0.4}) {
            const TriangleMesh mesh = shapes::icosphere(levels);
            nn::SphereDistances distances(mesh.vertices);
            const RoughShapes shapes(mesh.vertex_count(), 14, size);
            const Config config = fitted_by({{4, 0.4, 0.4}, {6, 0.3, 0.3}}, 6, 12);
            MultiscaleModel model(config, {mesh, distances, cases::Sphere::around(2)});
            std::vector<int> train(14);
            std::iota(train.begin(), train.end(), 0);
            const auto learner = model.learner(shapes, train);
            learner->start();
            BallComponents good;
            std::optional<SpaceState> good_space;
            TrainingState good_state;
            double first = 0, last = 0;
            int setbacks = 0;
            while (!learner->is_over()) {
                good = model.components();
                good_space = model.space_state;
                good_state = learner->state();
                try {
                    const EpochReport report = learner->run_epoch();
                    last = report.terms[1];
                    if (first == 0) first = last;
                } catch (const DivergenceError&) {
                    ASSERT_LT(++setbacks, 10) << mesh.vertex_count() << " vertices, " << size;
                    model.set_components(good);
                    model.space_state = good_space;
                    good_state.rate_factor = learner->state().rate_factor / 2;
                    learner->resume(good_state);
                }
            }
            EXPECT_LT(last, first) << mesh.vertex_count() << " vertices, " << size;
            RecordProperty("setbacks", setbacks);
        }
    }
}

// Whatever the rate, an epoch in space that is taken leaves the loss near its best; one that does
// not is refused, with the loss it came to, and changes nothing.
TEST(MultiscaleLearner, NoEpochThatGoesAstrayIsTaken) {
    cases::Sphere sphere;
    const RoughShapes shapes(sphere.vertices(), 14, 0.1);
    const Config config = fitted_by({{4, 0.4, 0.4}}, 4, 100);
    MultiscaleModel model(config, {sphere.mesh, sphere.distances, sphere.scale});
    std::vector<int> train(14);
    std::iota(train.begin(), train.end(), 0);
    const auto learner = model.learner(shapes, train);
    learner->start();
    while (learner->state().epoch < 5) learner->run_epoch();
    const TrainingState before = learner->state();
    const BallComponents good = model.components();
    const std::optional<SpaceState> good_space = model.space_state;
    int taken = 0, refused = 0;
    for (double rate = 1; rate < 1e4; rate *= 1.25) {
        TrainingState state = before;
        state.rate_factor = rate;
        learner->resume(state);
        try {
            EXPECT_LE(learner->run_epoch().total, 1.35 * before.total) << rate;
            ++taken;
        } catch (const DivergenceError& error) {
            refused += std::string(error.what()).find("the loss is") != std::string::npos ? 1 : 0;
            EXPECT_TRUE(std::ranges::equal(model.components().all_values(), good.all_values()));
        }
        model.set_components(good);
        model.space_state = good_space;
    }
    EXPECT_GT(taken, 0);
    EXPECT_GT(refused, 0);
}

// Fewer than three shapes cannot leave any out, and many need not choose.
TEST(MultiscaleLearner, ChoosesAmongFewShapesOnly) {
    cases::Sphere sphere;
    const RoughShapes shapes(sphere.vertices(), 30, 0.05);
    Config config;
    MultiscaleSettings settings;
    settings.global_components = 2;
    settings.levels = {{3, 0.3, 0.3}};
    settings.rounds = 2;
    config.settings = settings;
    config.train.fill_up_to = 40;
    for (const int count : {1, 2, 3, 23, 24, 30}) {
        MultiscaleModel model(config, {sphere.mesh, sphere.distances, sphere.scale});
        std::vector<int> train(at(count));
        std::iota(train.begin(), train.end(), 0);
        const auto learner = model.learner(shapes, train);
        learner->start();
        EXPECT_EQ(learner->notes().size(), count >= 3 && count < kFewShapes ? 4U : 0U) << count;
        if (count >= kFewShapes) {
            EXPECT_EQ(model.fill_up_to, 0);
            EXPECT_EQ(model.code_count(), 5);
        }
    }
}

// Components that are given keep their parents, whatever they overlap; those that are found have
// none but by overlap.
TEST(MultiscaleLearner, BeginsWithWhatItIsGiven) {
    cases::Sphere sphere;
    const RoughShapes shapes(sphere.vertices(), 5, 0.05);
    Config config;
    MultiscaleSettings settings;
    settings.global_components = 0;
    settings.levels = {{2, 0.3, 0.3}, {3, 0.3, 0.3}};
    settings.rounds = 0;
    config.settings = settings;
    config.train.fill_up_to = 7;
    MultiscaleModel model(config, {sphere.mesh, sphere.distances, sphere.scale});
    const BallComponents components = sphere.components(5, 0.2);
    GivenComponents given{components.vertex_count(), {{1, 2}, {1, 3}}, {-1, -1, 1, -1, 0}, {}, {}};
    given.changes = code_columns(components, model.map());
    for (const Ball& ball : components.balls()) given.centers.push_back(ball.center);
    const std::vector<int> train{0, 1, 2, 3, 4};
    const auto learner = model.learner(shapes, train);
    learner->start_from(given);
    EXPECT_EQ(model.parents(), given.parents);
    EXPECT_LT((cases::dense(model.components()) - cases::dense(components)).norm(), 1e-5);
    EXPECT_EQ(model.fill_up_to, 7);
    EXPECT_TRUE(learner->notes().empty());
    learner->run_epoch();
    EXPECT_EQ(model.parents(), given.parents);
    EXPECT_EQ(learner->state().step, SpaceDescent::kSteps);
    learner->start();
    EXPECT_NE(model.parents(), given.parents);
}

}  // namespace
}  // namespace mscomp

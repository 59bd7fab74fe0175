// SPDX-License-Identifier: MIT
// What every model kind that can be trained does, and the kinds themselves.
#include "mscomp/nn/kinds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numeric>

#include "base/temporary_folder.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "mscomp/nn/components.h"
#include "mscomp/nn/model_file.h"
#include "nn/start.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

class EachKind : public testing::TestWithParam<std::string> {
  protected:
    void SetUp() override {
        set_thread_count(1);  // many tiny passes
        config_ = default_config(GetParam());
        // Small, whichever of these the kind looks at.
        config_.stacked.levels.resize(std::min<std::size_t>(config_.stacked.levels.size(), 2));
        for (LevelConfig& level : config_.stacked.levels) level.components = 3;
        config_.spectral.components = 3;
        config_.train.fill_up_to = 14;
        config_.train.batch = 8;
        config_.train.plateau_epochs = 0;
    }
    void TearDown() override { set_thread_count(0); }

    std::unique_ptr<Model<float>> make(ModelUse use = ModelUse::training) {
        const OneRings rings =
            one_rings_of_faces(problem_.mesh.vertex_count(), problem_.mesh.faces);
        std::vector<double> weights;
        if (wants_edge_weights(config_)) weights.assign(rings.neighbors.size(), 1.0);
        return make_model(config_, rings, weights, problem_.distances, use, config_.train.batch);
    }
    std::unique_ptr<Trainer> train(Model<float>& model, int epochs) {
        auto trainer =
            std::make_unique<Trainer>(model, config_, problem_.features, problem_.shapes);
        trainer->start();
        for (int epoch = 0; epoch < epochs; ++epoch) trainer->run_epoch();
        return trainer;
    }
    std::string save(Model<float>& model, Trainer& trainer) {
        ModelContext context;
        context.reference = problem_.mesh;
        context.train_shapes = problem_.shapes;
        const std::string path = folder_ / "model.safetensors";
        write_model(path, model, context, trainer.state(), trainer.codes());
        return path;
    }
    /// Parameters and what Adam knows of them.
    static std::vector<float> state_of(Model<float>& model) {
        std::vector<float> all;
        for (const auto part : {model.parameters().all_values(), model.parameters().all_moments1(),
                                model.parameters().all_moments2()}) {
            all.insert(all.end(), part.begin(), part.end());
        }
        return all;
    }

    SmallTraining problem_;
    Config config_;
    TemporaryFolder folder_;
};

// A step lowers the loss: after twenty epochs it is lower than at the start, and finite.
TEST_P(EachKind, StartsAndLearns) {
    for (const Start start : {Start::deflation, Start::random}) {
        config_.train.start = start;
        config_.train.fill_up_to = 0;
        config_.train.batch = 12;
        const auto model = make();
        const auto trainer = train(*model, 1);
        EXPECT_EQ(model->term_names().size(), model->term_values().size());
        const double first = trainer->state().total;
        for (int epoch = 1; epoch < 21; ++epoch) trainer->run_epoch();
        EXPECT_EQ(trainer->state().step, 21);
        EXPECT_TRUE(trainer->state().total < first) << first << ", then " << trainer->state().total;
        for (const float x : state_of(*model)) ASSERT_TRUE(std::isfinite(x));
    }
}

// A model file holds all that a kind is made of: parameters, moments, centres, and what they give.
TEST_P(EachKind, LoadsWhatItSaved) {
    const auto model = make();
    const auto trainer = train(*model, 3);
    const ModelFile file(save(*model, *trainer));
    const auto loaded = make(), reading = make(ModelUse::reading);
    file.load(*loaded);
    file.load(*reading);
    EXPECT_EQ(state_of(*loaded), state_of(*model));
    EXPECT_EQ(file.codes(), trainer->codes());
    const auto results = [&](Model<float>& of) {
        const std::vector<int> some{1, 4, 7};
        of.load_batch(std::span<const float>(problem_.features), std::span<const int>(some));
        of.forward();
        const int levels = static_cast<int>(of.level_sizes().size());
        std::vector<float> all = of.reconstruction(levels);
        for (int l = 0; l < levels; ++l) {
            const std::vector<float> codes = of.codes(l);
            all.insert(all.end(), codes.begin(), codes.end());
        }
        const std::vector<float> ones(static_cast<std::size_t>(of.decoder()->code_count()), 0.3F);
        const std::vector<float> decoded = of.decoder()->decode(ones);
        all.insert(all.end(), decoded.begin(), decoded.end());
        return all;
    };
    const std::vector<float> wanted = results(*model);
    for (Model<float>* other : {loaded.get(), reading.get()}) {
        for (int l = 0; l < static_cast<int>(model->level_sizes().size()); ++l) {
            EXPECT_EQ(other->centers(l), model->centers(l)) << "level " << l;
        }
        EXPECT_EQ(results(*other), wanted);
    }
}

// Saved, loaded into a fresh model and continued ends in the bits of a run that never stopped, with
// mixed shapes, small batches and a change of the mixes; also right after a step that admits
// vertices, whose weights the proximal step may leave zero.
TEST_P(EachKind, ResumedIsUninterrupted) {
    const auto whole = make();
    train(*whole, 11);
    for (const int saved : {3, 4, 8}) {
        const auto first = make();
        const auto trainer = train(*first, saved);
        const ModelFile file(save(*first, *trainer));
        const auto second = make();
        file.load(*second);
        Trainer rest(*second, config_, problem_.features, problem_.shapes);
        rest.resume(file.state());
        for (int epoch = saved; epoch < 11; ++epoch) rest.run_epoch();
        EXPECT_EQ(state_of(*second), state_of(*whole)) << "saved at " << saved;
    }
}

TEST_P(EachKind, ThreadsDoNotChangeABit) {
    const auto one = make();
    train(*one, 3);
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        const auto many = make();
        train(*many, 3);
        EXPECT_EQ(state_of(*many), state_of(*one)) << threads << " threads";
    }
}

// One component for each code, with a centre on the mesh, finite, moving something.
TEST_P(EachKind, GivesComponents) {
    const auto model = make();
    const auto trainer = train(*model, 3);
    const std::vector<float> reference(problem_.mesh.vertices.size() * 9, 0.0F);
    std::array<double, kFeatureDim> factor;
    factor.fill(1);
    const std::vector<Component> components = extract_components(
        *model, trainer->codes(), reference, factor, config_.filter, problem_.distances);
    int codes = 0;
    for (const LevelSize& level : model->level_sizes()) codes += level.codes();
    ASSERT_EQ(static_cast<int>(components.size()), codes);
    EXPECT_EQ(model->decoder()->code_count(), codes);
    EXPECT_TRUE(std::ranges::any_of(components, [](const Component& c) { return c.kept; }));
    for (const Component& component : components) {
        EXPECT_TRUE(component.center >= 0 && component.center < problem_.mesh.vertex_count());
        EXPECT_LE(component.code_min, component.code_max);
        ASSERT_EQ(component.difference.size(), reference.size());
        for (const float x : component.difference) ASSERT_TRUE(std::isfinite(x));
        EXPECT_TRUE(!component.kept || component.strength >= config_.filter.minimum_strength);
    }
}

std::string name_of(const testing::TestParamInfo<std::string>& info) {
    std::string name;
    for (const char c : info.param) {
        if (std::isalnum(static_cast<unsigned char>(c)) != 0) name += c;
    }
    return name;
}
INSTANTIATE_TEST_SUITE_P(Kinds, EachKind, testing::ValuesIn(model_kinds()), name_of);

TEST(ModelKinds, UnknownOnesAreRefusedWithTheKnownOnes) {
    try {
        default_config("stacked");
        FAIL() << "made up a kind";
    } catch (const UsageError& error) {
        for (const std::string& kind : model_kinds()) {
            EXPECT_NE(std::string(error.what()).find(kind), std::string::npos) << error.what();
        }
    }
    for (const std::string& kind : model_kinds()) EXPECT_EQ(default_config(kind).kind, kind);
    EXPECT_EQ(model_kinds().front(), Config{}.kind);
}

// The predecessor with its ramp is a stacked model of one level with that ramp: Lambda is 0 up to
// `from`, 1 from `to` on and linear between, and the loss is the same number.
TEST(ModelKinds, AutoencoderIsOneLevelWithItsRamp) {
    SmallTraining problem;
    Config config = default_config("autoencoder");
    ASSERT_EQ(config.stacked.levels.size(), 1U);
    LevelConfig& level = config.stacked.levels[0];
    level.components = 3;
    level.max_support = 1;
    level.sparsity_ramp = {0.13, 0.42};
    config.train.supports = false;
    config.train.sparsity_step = SparsityStep::subgradient;
    const OneRings rings = one_rings_of_faces(problem.mesh.vertex_count(), problem.mesh.faces);
    const auto made = make_model(config, rings, {}, problem.distances, ModelUse::training, 12);
    auto* stacked = dynamic_cast<StackedModel<float>*>(made.get());
    ASSERT_NE(stacked, nullptr);
    ASSERT_EQ(stacked->levels().size(), 1U);
    const int center = stacked->order().to_internal[7];
    const SparsityRow row = stacked->levels()[0].sparsity->row(center);
    for (int v = 0; v < problem.mesh.vertex_count(); ++v) {
        const int user = stacked->order().to_user[static_cast<std::size_t>(v)];
        const double distance = problem.distances.row(7)[static_cast<std::size_t>(user)];
        EXPECT_NEAR(row.weight(v), std::clamp((distance - 0.13) / (0.42 - 0.13), 0.0, 1.0), 1e-12);
    }
    StackedModel<float>::Options options;
    options.batch = 12;
    options.sparsity_gradient = true;
    StackedModel<float> direct(config.stacked, config.loss, rings, problem.distances, options);
    const auto loss = [&](StackedModel<float>& model) {
        start_random(model, 2);
        model.load_batch(std::span<const float>(problem.features),
                         std::span<const int>(problem.shapes));
        return model.forward();
    };
    EXPECT_EQ(loss(*stacked), loss(direct));
    level.sparsity_ramp.reset();
    StackedModel<float> step(config.stacked, config.loss, rings, problem.distances, options);
    EXPECT_NE(loss(step), loss(direct));
}

}  // namespace
}  // namespace mscomp::nn

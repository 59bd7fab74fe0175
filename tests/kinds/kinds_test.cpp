// SPDX-License-Identifier: MIT
// What every model kind that can be trained does, and the kinds themselves.
#include "mscomp/kinds/kinds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numeric>

#include "base/temporary_folder.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/edit/feature_fit.h"
#include "mscomp/model/components.h"
#include "mscomp/model/divergence.h"
#include "mscomp/model/model_file.h"
#include "mscomp/multiscale/multiscale.h"
#include "mscomp/nn/kinds.h"
#include "mscomp/units/units.h"
#include "nn/network.h"
#include "nn/network_files.h"
#include "nn/small_training.h"
#include "nn/stacked_model.h"
#include "nn/start.h"

namespace mscomp::nn {
namespace {

/// Shapes in memory: features around the reference, and vertices that move along with them.
class MemoryShapes final : public ShapeSet {
  public:
    explicit MemoryShapes(const SmallTraining& problem)
        : vertex_count_(problem.mesh.vertex_count()), features_(problem.features) {
        for (std::size_t i = 0; i < features_.size(); ++i) {
            features_[i] += kReferenceFeature[i % kFeatureDim];
        }
        for (std::size_t m = 0; m < problem.shapes.size(); ++m) {
            for (std::size_t v = 0; v < problem.mesh.vertices.size(); ++v) {
                const std::size_t row = (m * problem.mesh.vertices.size() + v) * kFeatureDim;
                for (std::size_t x = 0; x < 3; ++x) {
                    vertices_.push_back(static_cast<float>(problem.mesh.vertices[v][x]) +
                                        problem.features[row + x]);
                }
            }
        }
    }
    int shape_count() const override {
        return static_cast<int>(features_.size()) / (vertex_count_ * kFeatureDim);
    }
    int vertex_count() const override { return vertex_count_; }
    std::span<const float> shape(int index) const override { return row(features_, index, 9); }
    std::span<const float> vertices(int index) const override { return row(vertices_, index, 3); }
    void forget(int) const override {}

  private:
    std::span<const float> row(const std::vector<float>& all, int index, int width) const {
        const auto size = static_cast<std::size_t>(vertex_count_ * width);
        return std::span(all).subspan(static_cast<std::size_t>(index) * size, size);
    }

    int vertex_count_;
    std::vector<float> features_, vertices_;
};

/// All kinds, and those of other rows than they have by default.
std::vector<std::string> variants() {
    std::vector<std::string> all = kind_names();
    all.emplace_back("units of positions");
    return all;
}

class EachKind : public testing::TestWithParam<std::string> {
  protected:
    void SetUp() override {
        set_thread_count(1);  // many tiny passes
        config_ = default_config(kind());
        if (GetParam().ends_with(" of positions")) {
            config_.own<UnitSettings>().rows = ShapeRows::positions;
        }
        // Small, whichever of these the kind has.
        if (auto* stacked = std::any_cast<StackedSettings>(&config_.settings)) {
            for (LevelConfig& level : stacked->model.levels) level.components = 3;
        }
        if (auto* spectral = std::any_cast<SpectralSettings>(&config_.settings)) {
            spectral->model.components = 3;
        }
        if (auto* multiscale = std::any_cast<MultiscaleSettings>(&config_.settings)) {
            multiscale->global_components = 1;
            multiscale->levels = {{3, 0.4, 0.5}, {6, 0.3, 0.3}};
            multiscale->rounds = 5;
            multiscale->select = false;
        }
        config_.train.fill_up_to = 14;
        config_.train.batch = 8;
        config_.train.plateau_epochs = 0;
        use_scale(1);
    }
    void TearDown() override { set_thread_count(0); }

    /// Features times `factor`, and those of some vertices counting more than those of others.
    void use_scale(double factor) {
        scale_ = around_reference(factor);
        for (int v = 0; v < problem_.mesh.vertex_count(); ++v) {
            scale_.roots.push_back(v % 3 == 0 ? 1.25F : 0.75F);
        }
    }
    /// Over after one epoch: it has no rate, and nothing to descend.
    bool is_closed_form() const { return kind() == "units" || kind() == "pca"; }
    bool works_on_features() const {
        return kind_named(kind()).rows(config_) == ShapeRows::features;
    }
    static std::string kind() { return GetParam().substr(0, GetParam().find(' ')); }
    std::unique_ptr<LearnedModel> make(ModelUse use = ModelUse::training) {
        const std::size_t edges =
            one_rings_of_faces(problem_.mesh.vertex_count(), problem_.mesh.faces).neighbors.size();
        const ModelPlace place{problem_.mesh, problem_.distances, scale_, use, 12, [edges] {
                                   return std::vector<double>(edges, 1.0);
                               }};
        return kind_named(kind()).make(config_, place);
    }
    std::unique_ptr<Learner> train(LearnedModel& model, int epochs) {
        auto learner = model.learner(shapes_, problem_.shapes);
        learner->start();
        go_on(*learner, epochs);
        return learner;
    }
    /// Up to so many epochs, or as many as the method takes.
    static void go_on(Learner& learner, int epochs) {
        while (learner.state().epoch < epochs && !learner.is_over()) learner.run_epoch();
    }
    std::string save(LearnedModel& model, Learner& learner) {
        ModelContext context;
        context.reference = problem_.mesh;
        context.train_shapes = problem_.shapes;
        const std::string path = folder_ / "model.safetensors";
        write_model(path, model, context, learner.state(), learner.codes());
        return path;
    }
    /// All that a model file holds: parameters, what the optimiser knows of them, centres, codes.
    std::string state_of(LearnedModel& model, Learner& learner) {
        return read_file(save(model, learner));
    }

    SmallTraining problem_;
    MemoryShapes shapes_{problem_};
    MetricScale scale_;
    Config config_;
    TemporaryFolder folder_;
};

// A step lowers the loss: after twenty epochs it is lower than at the start, and finite. A closed
// form is over after one.
TEST_P(EachKind, StartsAndLearns) {
    for (const Start start : {Start::deflation, Start::random}) {
        config_.train.start = start;
        config_.train.fill_up_to = 0;
        config_.train.batch = 12;
        if (auto* multiscale = std::any_cast<MultiscaleSettings>(&config_.settings)) {
            multiscale->rounds = 21;
        }
        const auto model = make();
        const auto learner = model->learner(shapes_, problem_.shapes);
        learner->start();
        const EpochReport report = learner->run_epoch();
        EXPECT_EQ(report.terms.size(), learner->term_names().size());
        const double first = learner->state().total;
        go_on(*learner, 21);
        const double last = learner->state().total;
        EXPECT_TRUE(std::isfinite(last));
        if (is_closed_form()) continue;
        EXPECT_EQ(learner->state().step, 21);
        EXPECT_TRUE(last < first) << first << ", then " << last;
    }
}

// A model file holds all that a kind is made of, and what it gives.
TEST_P(EachKind, LoadsWhatItSaved) {
    config_.train.batch = 14;  // as many lanes as for reading: other widths round differently
    const auto model = make();
    const auto learner = train(*model, 3);
    const ModelFile file(save(*model, *learner));
    const auto loaded = make(), reading = make(ModelUse::reading);
    file.load(*loaded);
    file.load(*reading);
    EXPECT_EQ(file.codes().values, learner->codes().values);
    EXPECT_EQ(file.codes().code_count, model->code_count());
    const auto results = [&](LearnedModel& of) {
        const std::vector<int> some{1, 4, 7};
        std::vector<float> all = of.encode(shapes_, some).values;
        for (const std::vector<float>& more :
             {of.reference_codes(), of.decode(std::vector<float>(at(of.code_count()), 0.3F)),
              of.decode(std::vector<float>(at(of.code_count()), 0.3F), 1)}) {
            all.insert(all.end(), more.begin(), more.end());
        }
        for (const ComponentPlace& place : of.places()) {
            for (const int x : {place.center, place.longest, place.support}) {
                all.push_back(static_cast<float>(x));
            }
        }
        return all;
    };
    const std::vector<float> wanted = results(*model);
    for (LearnedModel* other : {loaded.get(), reading.get()}) EXPECT_EQ(results(*other), wanted);
}

// Saved, loaded into a fresh model and continued ends in the bits of a run that never stopped, with
// mixed shapes, small batches and a change of the mixes; also right after a step that admits
// vertices, whose weights the proximal step may leave zero.
TEST_P(EachKind, ResumedIsUninterrupted) {
    const auto whole = make();
    const auto whole_learner = train(*whole, 11);
    const std::string wanted = state_of(*whole, *whole_learner);
    for (const int saved : {3, 4, 8}) {
        const auto first = make();
        const auto learner = train(*first, saved);
        const ModelFile file(save(*first, *learner));
        const auto second = make();
        const auto rest = second->learner(shapes_, problem_.shapes);
        file.load(*second);
        rest->resume(file.state());
        go_on(*rest, 11);
        EXPECT_EQ(state_of(*second, *rest), wanted) << "saved at " << saved;
    }
}

// A rate far too high is noticed, at the latest when the model shall be saved, and an earlier state
// loaded into the very same model goes on as if nothing had been.
TEST_P(EachKind, WhatGoesAstrayIsNoticedAndUndone) {
    if (is_closed_form()) GTEST_SKIP() << "a closed form has no rate";
    const auto model = make();
    const auto learner = train(*model, 4);
    const ModelFile good(save(*model, *learner));
    go_on(*learner, 9);
    const std::string wanted = state_of(*model, *learner);
    for (const double rate : {1.0, 1e3, 1e19, 1e38}) {
        TrainingState wild = good.state();
        good.load(*model);
        wild.rate_factor = rate / config_.train.learning_rate;
        learner->resume(wild);
        EXPECT_THROW(
            {
                go_on(*learner, 9);
                learner->codes();
            },
            DivergenceError)
            << rate;
        good.load(*model);
        learner->resume(good.state());
        go_on(*learner, 9);
        EXPECT_EQ(state_of(*model, *learner), wanted) << rate;
    }
}

// Nothing that trains is taken for astray, whatever the reading: after every epoch, for long.
TEST_P(EachKind, WhatTrainsIsNotTakenForAstray) {
    for (const Start start : {Start::deflation, Start::random}) {
        for (const SparsityStep step : {SparsityStep::proximal, SparsityStep::subgradient}) {
            for (const double rate : {1e-4, 3e-3, 1e-2}) {
                config_.train.start = start;
                config_.train.sparsity_step = step;
                config_.train.learning_rate = rate;
                const auto model = make();
                const auto learner = model->learner(shapes_, problem_.shapes);
                learner->start();
                while (learner->state().epoch < 30 && !learner->is_over()) {
                    learner->codes();
                    ASSERT_NO_THROW(learner->run_epoch()) << rate;
                }
                EXPECT_NO_THROW(learner->codes());
                // It has none of what these loops change.
                if (std::any_cast<MultiscaleSettings>(&config_.settings) != nullptr) return;
            }
        }
    }
}

// The reference is at zero, and without biases what is zero comes back as zero: training moves it
// nowhere.
TEST_P(EachKind, GivesItsReferenceBack) {
    if (kind() == "pca") GTEST_SKIP() << "principal components are around the mean";
    use_scale(2);
    if (auto* stacked = std::any_cast<StackedSettings>(&config_.settings)) {
        stacked->model.bias = false;
    }
    const auto model = make();
    const auto learner = train(*model, 10);
    const std::vector<float> codes = model->reference_codes();
    for (const float code : codes) EXPECT_EQ(code, 0.0F);
    const std::vector<float> rows = model->decode(codes);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const float rest = works_on_features()
                               ? kReferenceFeature[i % kFeatureDim]
                               : static_cast<float>(problem_.mesh.vertices[i / 3][i % 3]);
        ASSERT_EQ(rows[i], rest) << i;
    }
}

TEST_P(EachKind, ThreadsDoNotChangeABit) {
    const auto one = make();
    const auto learner = train(*one, 3);
    const std::string wanted = state_of(*one, *learner);
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        const auto many = make();
        const auto many_learner = train(*many, 3);
        EXPECT_EQ(state_of(*many, *many_learner), wanted) << threads << " threads";
    }
}

// One component for each code, with a centre on the mesh, finite, moving something.
TEST_P(EachKind, GivesComponents) {
    const auto model = make();
    const auto learner = train(*model, 3);
    const std::vector<Component> components =
        extract_components(*model, learner->codes(), config_.filter, problem_.distances);
    ASSERT_EQ(static_cast<int>(components.size()), model->code_count());
    EXPECT_TRUE(std::ranges::any_of(components, [](const Component& c) { return c.kept; }));
    const std::size_t size = problem_.mesh.vertices.size() * at(row_width(model->rows()));
    for (const Component& component : components) {
        EXPECT_TRUE(component.center >= 0 && component.center < problem_.mesh.vertex_count());
        EXPECT_LE(component.code_min, component.code_max);
        ASSERT_EQ(component.difference.size(), size);
        for (const float x : component.difference) ASSERT_TRUE(std::isfinite(x));
        EXPECT_TRUE(!component.kept || component.cost > 0) << component.id;
        EXPECT_EQ(component.kept, component.reason.empty());
    }
}

// Fitted to features in the metric of the kind they are no farther than as encoded; the encoder of
// `multiscale` and `units` is that fit already.
TEST_P(EachKind, JointCodesAreNoFartherThanThoseOfTheEncoder) {
    use_scale(2);
    const auto model = make();
    train(*model, 3);
    if (!works_on_features()) {
        EXPECT_THROW(FeatureFit{*model}, UsageError);
        return;
    }
    const double count = problem_.mesh.vertex_count();
    FeatureFitOptions options;
    options.scale = scale_;
    const FeatureFit fit(*model, options);
    const bool is_joint = kind() == "multiscale" || kind() == "units";
    const std::vector<int> some{1, 4, 7};
    const CodeTable table = model->encode(shapes_, some);
    for (int m = 0; m < 3; ++m) {
        const std::span<const float> truth = shapes_.shape(some[at(m)]), codes = table.shape(m);
        const std::vector<float> rows = model->decode(codes);
        double squares = 0;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const double away = static_cast<double>(rows[i]) - static_cast<double>(truth[i]);
            squares += std::pow(away * scale_.scale_factor(i / kFeatureDim, i % kFeatureDim), 2);
        }
        const FittedCodes found = fit.fit(truth, codes);
        const double initial = std::sqrt(squares / (count * kFeatureDim));
        EXPECT_NEAR(found.initial_rms, initial, 1e-6 * initial);
        EXPECT_LE(found.rms, found.initial_rms);
        if (!is_joint) {
            EXPECT_LT(found.rms, 0.999 * initial);
            continue;
        }
        EXPECT_GT(found.rms, (1 - 1e-5) * initial);
        const FittedCodes from_zero = fit.fit(truth, model->reference_codes());
        EXPECT_LE(from_zero.steps, 2);
        EXPECT_NEAR(from_zero.rms, initial, 1e-5 * initial);
    }
}

// What the configuration says the codes decode to is what the model says.
TEST_P(EachKind, DecodesToTheRowsOfItsConfiguration) {
    const auto model = make();
    EXPECT_EQ(model->rows(), kind_named(kind()).rows(config_));
    const auto size = problem_.mesh.vertices.size() * at(row_width(model->rows()));
    const auto learner = train(*model, 1);
    EXPECT_EQ(model->decode(std::vector<float>(at(model->code_count()))).size(), size);
    EXPECT_EQ(works_on_features(), GetParam() != "pca" && GetParam() != "units of positions");
}

// What everything else builds on: change() is the difference of two decode(), derivatives() are
// those of decode(), and what a code does not change is exactly zero.
TEST_P(EachKind, DerivativesAndChangesAreThoseOfDecode) {
    const auto model = make();
    const auto learner = train(*model, 2);
    const CodeTable codes = learner->codes();
    const std::vector<float> z(codes.shape(1).begin(), codes.shape(1).end());
    const std::vector<float> base = model->decode(z);
    const std::vector<CodeColumn> columns = model->derivatives(z);
    ASSERT_EQ(columns.size(), z.size());
    for (std::size_t k = 0; k < z.size(); ++k) {
        constexpr float kStep = 0.02F;
        std::vector<float> up = z, down = z;
        up[k] += kStep;
        down[k] -= kStep;
        const std::vector<float> change = model->change(up, down);
        std::vector<float> slope(base.size(), 0.0F);
        const auto width = at(row_width(model->rows()));
        for (std::size_t i = 0; i < columns[k].values.size(); ++i) {
            slope[at(columns[k].vertices[i / width]) * width + i % width] = columns[k].values[i];
        }
        const std::vector<float> at_up = model->decode(up), at_down = model->decode(down);
        for (std::size_t i = 0; i < slope.size(); ++i) {
            ASSERT_NEAR(change[i], at_up[i] - at_down[i], 1e-5) << "code " << k;
            ASSERT_NEAR(change[i] / (2 * kStep), slope[i], 2e-3) << "code " << k;
        }
    }
    for (const float x : model->change(z, z)) ASSERT_EQ(x, 0.0F);
}

std::string name_of(const testing::TestParamInfo<std::string>& info) {
    std::string name;
    for (const char c : info.param) {
        if (std::isalnum(static_cast<unsigned char>(c)) != 0) name += c;
    }
    return name;
}
INSTANTIATE_TEST_SUITE_P(Kinds, EachKind, testing::ValuesIn(variants()), name_of);

TEST(ModelKinds, UnknownOnesAreRefusedWithTheKnownOnes) {
    try {
        default_config("stacked");
        FAIL() << "made up a kind";
    } catch (const UsageError& error) {
        for (const std::string& kind : kind_names()) {
            EXPECT_NE(std::string(error.what()).find(kind), std::string::npos) << error.what();
        }
    }
    for (const std::string& kind : kind_names()) EXPECT_EQ(default_config(kind).kind, kind);
    EXPECT_EQ(kind_names().front(), "multiscale");
}

// The predecessor with its ramp is a stacked model of one level with that ramp: Lambda is 0 up to
// `from`, 1 from `to` on and linear between, and the loss is the same number.
TEST(ModelKinds, AutoencoderIsOneLevelWithItsRamp) {
    SmallTraining problem;
    Config config = default_config("autoencoder");
    auto& own = config.own<StackedSettings>();
    ASSERT_EQ(own.model.levels.size(), 1U);
    LevelConfig& level = own.model.levels[0];
    level.components = 3;
    level.max_support = 1;
    level.sparsity_ramp = {0.13, 0.42};
    config.train.supports = false;
    config.train.sparsity_step = SparsityStep::subgradient;
    const OneRings rings = one_rings_of_faces(problem.mesh.vertex_count(), problem.mesh.faces);
    config.train.fill_up_to = 0;
    const ModelPlace place{problem.mesh, problem.distances, {}, ModelUse::training, 12, {}};
    const auto made = kind_named("autoencoder").make(config, place);
    auto* network = dynamic_cast<Network*>(made.get());
    ASSERT_NE(network, nullptr);
    auto* stacked = dynamic_cast<StackedModel<float>*>(&network->model());
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
    StackedModel<float> direct(own.model, own.loss, rings, problem.distances, options);
    const auto loss = [&](StackedModel<float>& model) {
        start_random(model, 2);
        model.load_batch(std::span<const float>(problem.features),
                         std::span<const int>(problem.shapes));
        return model.forward();
    };
    EXPECT_EQ(loss(*stacked), loss(direct));
    level.sparsity_ramp.reset();
    StackedModel<float> step(own.model, own.loss, rings, problem.distances, options);
    EXPECT_NE(loss(step), loss(direct));
}

}  // namespace
}  // namespace mscomp::nn

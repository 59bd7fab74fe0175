// SPDX-License-Identifier: MIT
#include "mscomp/nn/trainer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "base/temporary_folder.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/nn/model_file.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

class Training : public testing::Test {
  protected:
    void TearDown() override { set_thread_count(0); }

    std::string temporary(const char* name) { return folder_ / name; }

  private:
    TemporaryFolder folder_;
};

std::vector<float> trained(SmallTraining& problem, int epochs) {
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config, problem.features, problem.shapes);
    trainer.start();
    for (int epoch = 0; epoch < epochs; ++epoch) trainer.run_epoch();
    return all_of(*model);
}

// The same training with 1, 2 and 7 threads gives the same bits.
TEST_F(Training, ThreadsDoNotChangeABit) {
    SmallTraining problem;
    set_thread_count(1);
    const std::vector<float> one = trained(problem, 5);
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        EXPECT_EQ(trained(problem, 5), one) << threads << " threads";
    }
}

// The same with batches that are gathered beside the steps.
TEST_F(Training, ThreadsDoNotChangeABitOfSmallBatches) {
    SmallTraining problem;
    problem.config.train.batch = 5;
    set_thread_count(1);
    const std::vector<float> one = trained(problem, 4);
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        EXPECT_EQ(trained(problem, 4), one) << threads << " threads";
    }
}

/// Features in memory that count how often they are read, and fail from one read on.
class CountedFeatures final : public ShapeFeatures {
  public:
    CountedFeatures(std::span<const float> features, int vertices) : memory_(features, vertices) {}

    mutable int reads = 0;
    int reads_before_failure = std::numeric_limits<int>::max();

    int shape_count() const override { return memory_.shape_count(); }
    int vertex_count() const override { return memory_.vertex_count(); }
    std::span<const float> shape(int index) const override {
        if (++reads > reads_before_failure) throw InputError({"f.safetensors"}, "ends too early");
        return memory_.shape(index);
    }
    void forget(int) const override {}

  private:
    MemoryFeatures memory_;
};

// Scaled on the way, in whatever batches, features train as those that were scaled before.
TEST_F(Training, ScalingOnTheWayChangesNoBit) {
    SmallTraining problem;
    for (const int batch : {5, 12}) {
        problem.config.train.batch = batch;
        const std::vector<float> before = trained(problem, 3);
        // Powers of two: scaling there and back is exact.
        std::vector<float> unscaled = problem.features;
        for (float& x : unscaled) x /= 4;
        const MemoryFeatures memory(unscaled, problem.mesh.vertex_count());
        ScaledFeatures features{memory};
        features.factor.fill(4);
        const auto model = problem.make_model();
        Trainer trainer(*model, problem.config, features, problem.shapes);
        trainer.start();
        for (int epoch = 0; epoch < 3; ++epoch) trainer.run_epoch();
        EXPECT_EQ(all_of(*model), before) << "batches of " << batch;
    }
}

TEST_F(Training, ReadsOnceWhatFitsIntoOneBatch) {
    SmallTraining problem;
    const CountedFeatures counted(problem.features, problem.mesh.vertex_count());
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config, ScaledFeatures{counted}, problem.shapes);
    trainer.start();
    trainer.run_epoch();
    const int reads = counted.reads;
    trainer.run_epoch();
    trainer.codes();
    trainer.run_epoch();
    EXPECT_EQ(counted.reads, reads);
}

// What goes wrong in the thread that gathers stops training before the step that needs it.
TEST_F(Training, AFailureToReadStopsBeforeTheStep) {
    SmallTraining problem;
    problem.config.train.batch = 5;
    CountedFeatures counted(problem.features, problem.mesh.vertex_count());
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config, ScaledFeatures{counted}, problem.shapes);
    trainer.start();
    counted.reads_before_failure = counted.reads + 7;  // in the second batch
    try {
        trainer.run_epoch();
        FAIL() << "trained on what could not be read";
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), InputError({"f.safetensors"}, "ends too early").what());
    }
    EXPECT_EQ(trainer.state().step, 1);
}

// Saved, loaded into a fresh model and continued gives the bits of a run that never stopped, with
// batches smaller than the set, where the order of the shapes is drawn anew each epoch.
TEST_F(Training, ResumedIsUninterrupted) {
    SmallTraining problem;
    problem.config.train.batch = 5;
    const std::vector<float> whole = trained(problem, 8);

    const std::string path = temporary("resume.safetensors");
    ModelContext context;
    context.reference = problem.mesh;
    context.train_shapes = problem.shapes;
    {
        const auto model = problem.make_model();
        Trainer trainer(*model, problem.config, problem.features, problem.shapes);
        trainer.start();
        for (int epoch = 0; epoch < 3; ++epoch) trainer.run_epoch();
        write_model(path, *model, context, trainer.state(), trainer.codes());
    }
    const ModelFile file(path);
    EXPECT_EQ(file.state().epoch, 3);
    EXPECT_EQ(file.state().step, 9);
    const auto model = problem.make_model();
    file.load(*model);
    Trainer trainer(*model, problem.config, problem.features, problem.shapes);
    trainer.resume(file.state());
    for (int epoch = 3; epoch < 8; ++epoch) trainer.run_epoch();
    EXPECT_EQ(all_of(*model), whole);
}

// Reading codes for a checkpoint does not disturb training.
TEST_F(Training, SavingOnTheWayChangesNothing) {
    SmallTraining problem;
    const std::vector<float> undisturbed = trained(problem, 4);
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config, problem.features, problem.shapes);
    trainer.start();
    for (int epoch = 0; epoch < 4; ++epoch) {
        trainer.run_epoch();
        trainer.codes();
    }
    EXPECT_EQ(all_of(*model), undisturbed);
}

// As many components as the data have: reconstruction goes towards zero.
TEST_F(Training, OverfitsFourShapes) {
    SmallTraining problem(4, 2);
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config, problem.features, problem.shapes);
    trainer.start();
    double first = 0, last = 0;
    for (int epoch = 0; epoch < 300; ++epoch) {
        const EpochReport report = trainer.run_epoch();
        last = report.terms[3];
        if (epoch == 0) first = report.terms[0];
    }
    double energy = 0;
    for (const float x : problem.features)
        energy += static_cast<double>(x) * static_cast<double>(x);
    EXPECT_TRUE(first < 0.2 * energy / 4) << "the deflation start explains most: " << first;
    EXPECT_TRUE(last < 0.01 * energy / 4) << last << " of " << energy / 4;
}

// A feature that is not finite stops training before the update and names what broke.
TEST_F(Training, StopsAtNaNBeforeTheUpdate) {
    SmallTraining problem;
    const auto model = problem.make_model();
    Trainer trainer(*model, problem.config, problem.features, problem.shapes);
    trainer.start();
    trainer.run_epoch();
    const std::vector<float> before = all_of(*model);
    problem.features[100] = std::numeric_limits<float>::quiet_NaN();
    Trainer poisoned(*model, problem.config, problem.features, problem.shapes);
    poisoned.resume(trainer.state());
    try {
        poisoned.run_epoch();
        FAIL() << "trained on NaN";
    } catch (const NumericalError& error) {
        EXPECT_NE(std::string(error.what()).find("step 2: the result of autoencoder"),
                  std::string::npos)
            << error.what();
    }
    EXPECT_EQ(all_of(*model), before);
}

class ModelFileTest : public Training {
  protected:
    std::string saved() {
        const auto model = problem_.make_model();
        Trainer trainer(*model, problem_.config, problem_.features, problem_.shapes);
        trainer.start();
        ModelContext context;
        context.config = "model: {}";
        context.reference = problem_.mesh;
        context.factor.fill(2.0);
        context.train_shapes = problem_.shapes;
        const std::string path = temporary("model.safetensors");
        write_model(path, *model, context, trainer.state(), trainer.codes());
        return path;
    }
    SmallTraining problem_;
};

TEST_F(ModelFileTest, KeepsItsContext) {
    const ModelFile file(saved());
    EXPECT_EQ(file.context().config, "model: {}");
    EXPECT_EQ(file.context().reference.vertices, problem_.mesh.vertices);
    EXPECT_EQ(file.context().reference.faces, problem_.mesh.faces);
    EXPECT_EQ(file.context().factor[8], 2.0);
    EXPECT_EQ(file.context().train_shapes, problem_.shapes);
    ASSERT_EQ(file.codes().size(), 2u);
    EXPECT_EQ(file.codes()[1].size(), 12u * 3 * 2);
}

// Every array in the vertex order of the user, under its name.
TEST_F(ModelFileTest, HoldsArraysInTheOrderOfTheUser) {
    const auto model = problem_.make_model();
    Trainer trainer(*model, problem_.config, problem_.features, problem_.shapes);
    trainer.start();
    for (int epoch = 0; epoch < 2; ++epoch) trainer.run_epoch();
    ModelContext context;
    context.reference = problem_.mesh;
    context.train_shapes = problem_.shapes;
    const std::string path = temporary("model.safetensors");
    write_model(path, *model, context, trainer.state(), trainer.codes());
    const SafetensorsFile file(path);
    ParameterSet<float>& parameters = model->parameters();
    for (int i = 0; i < parameters.count(); ++i) {
        const ParameterSet<float>::Entry& entry = parameters.entry(i);
        const auto expect_held = [&](const std::string& prefix, std::span<const float> inner) {
            const auto held = file.data<float>(prefix + "/" + entry.name, entry.extents);
            EXPECT_TRUE(std::ranges::equal(held, model->to_user_order(i, inner)))
                << prefix << " of " << entry.name;
        };
        expect_held("parameter", parameters.value(i));
        expect_held("adam_m", parameters.moment1(i));
        expect_held("adam_v", parameters.moment2(i));
    }
}

// Whatever a model held before, zeros of the file included, it holds the file afterwards.
TEST_F(ModelFileTest, ReplacesAllThatWasThere) {
    const ModelFile file(saved());
    const auto fresh = problem_.make_model(), used = problem_.make_model();
    ParameterSet<float>& parameters = used->parameters();
    for (const auto all :
         {parameters.all_values(), parameters.all_moments1(), parameters.all_moments2()}) {
        std::ranges::fill(all, 3.0F);
    }
    file.load(*fresh);
    file.load(*used);
    for (int i = 0; i < parameters.count(); ++i) {
        const std::string& name = parameters.entry(i).name;
        EXPECT_TRUE(std::ranges::equal(parameters.value(i), fresh->parameters().value(i))) << name;
        EXPECT_TRUE(std::ranges::equal(parameters.moment1(i), fresh->parameters().moment1(i)))
            << name;
        EXPECT_TRUE(std::ranges::equal(parameters.moment2(i), fresh->parameters().moment2(i)))
            << name;
    }
    EXPECT_TRUE(std::ranges::any_of(fresh->parameters().value(0), [](float x) { return x != 0; }));
}

TEST_F(ModelFileTest, RefusesATruncatedFile) {
    const std::string path = saved();
    const std::string bytes = read_file(path);
    for (const std::size_t kept :
         {std::size_t{0}, std::size_t{7}, bytes.size() / 2, bytes.size() - 1}) {
        std::ofstream(path, std::ios::binary)
            .write(bytes.data(), static_cast<std::streamsize>(kept));
        EXPECT_THROW(ModelFile{path}, CheckpointError)
            << kept << " of " << bytes.size() << " bytes";
    }
}

TEST_F(ModelFileTest, RefusesAlteredBytes) {
    const std::string path = saved();
    const std::string bytes = read_file(path);
    for (const std::size_t place : {std::size_t{20}, bytes.size() / 2, bytes.size() - 3}) {
        std::string altered = bytes;
        altered[place] = static_cast<char>(altered[place] ^ 0x10);
        write_file(path, altered);
        EXPECT_THROW(ModelFile{path}, CheckpointError) << "byte " << place;
    }
}

// Who acts is decided in some steps only, so it is restored, not read off the weights.
TEST_F(ModelFileTest, RestoresWhoActs) {
    const auto model = problem_.make_model();
    Trainer trainer(*model, problem_.config, problem_.features, problem_.shapes);
    trainer.start();
    std::vector<std::uint8_t> acts = model->acting(1);
    std::vector<std::uint8_t> more = acts;
    for (std::size_t i = 0; i < more.size(); i += 5) more[i] = 1;
    ASSERT_NE(more, acts);
    model->set_acting(1, more);
    ModelContext context;
    context.reference = problem_.mesh;
    context.train_shapes = problem_.shapes;
    const std::string path = temporary("acting.safetensors");
    write_model(path, *model, context, trainer.state(), trainer.codes());
    const auto loaded = problem_.make_model();
    ModelFile(path).load(*loaded);
    EXPECT_EQ(loaded->acting(1), more);
}

// A settled centre need not be the longest vertex, so it is restored, not found again.
TEST_F(ModelFileTest, RestoresCentres) {
    const auto model = problem_.make_model();
    Trainer trainer(*model, problem_.config, problem_.features, problem_.shapes);
    trainer.start();
    const std::vector<int> coarse{5, 17, 160}, fine{9, 8, 7, 6, 5, 4};
    model->set_centers(0, coarse);
    model->set_centers(1, fine);
    ModelContext context;
    context.reference = problem_.mesh;
    context.train_shapes = problem_.shapes;
    std::vector<std::vector<float>> codes{std::vector<float>(12 * 3), std::vector<float>(12 * 6)};
    const std::string path = temporary("centres.safetensors");
    write_model(path, *model, context, trainer.state(), codes);
    const auto loaded = problem_.make_model();
    ModelFile(path).load(*loaded);
    ASSERT_EQ(loaded->centers(0), coarse);
    EXPECT_EQ(loaded->centers(1), fine);
    // Inner numbering too, against the order that brings vertices there.
    EXPECT_EQ(loaded->order()
                  .to_user[static_cast<std::size_t>(loaded->levels()[0].sparsity->centers()[2])],
              160);
    const SparsityRow row =
        loaded->levels()[0].sparsity->row(loaded->levels()[0].sparsity->centers()[2]);
    EXPECT_EQ(row.distances[static_cast<std::size_t>(loaded->order().to_internal[160])], 0);
}

// Content that no training can have written, though the bytes are whole.
TEST_F(ModelFileTest, RefusesContentThatCannotBe) {
    const auto model = problem_.make_model();
    ModelContext context;
    context.reference = problem_.mesh;
    context.train_shapes = problem_.shapes;
    model->set_centers(0, {0, 1, 2});
    model->set_centers(1, {0, 1, 2, 3, 4, 5});
    std::vector<std::vector<float>> codes{std::vector<float>(12 * 3), std::vector<float>(12 * 6)};
    const std::string path = temporary("model.safetensors");
    const auto load = [&] {
        write_model(path, *model, context, {}, codes);
        const auto fresh = problem_.make_model();
        ModelFile(path).load(*fresh);
    };
    EXPECT_NO_THROW(load());
    std::swap(context.train_shapes[0], context.train_shapes[1]);
    EXPECT_THROW(load(), CheckpointError) << "shapes in disorder";
    context.train_shapes = problem_.shapes;
    codes[1].resize(11 * 6);
    EXPECT_THROW(load(), CheckpointError) << "a shape without codes";
    codes[1].resize(12 * 6);
    model->set_centers(0, {0, 1, -1});
    EXPECT_THROW(load(), CheckpointError) << "a component without centre";
    model->set_centers(0, {0, 1, 2});
    model->parameters().value(0)[3] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(load(), CheckpointError) << "a parameter that is not finite";
    model->parameters().value(0)[3] = 0;
    model->parameters().value(model->levels()[1].weights).back() =
        std::numeric_limits<float>::infinity();
    EXPECT_THROW(load(), CheckpointError) << "a component weight that is not finite";
}

TEST_F(ModelFileTest, RefusesAModelOfAnotherShape) {
    const ModelFile file(saved());
    problem_.config.stacked.levels[0].components = 4;
    const auto model = problem_.make_model();
    EXPECT_THROW(file.load(*model), CheckpointError);
}

}  // namespace
}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <list>
#include <utility>

#include "base/temporary_folder.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/model/model_file.h"
#include "network_files.h"
#include "nn/start.h"
#include "small_spectral.h"
#include "small_training.h"

namespace mscomp::nn {
namespace {

class ModelFileTest : public testing::Test {
  protected:
    std::string temporary(const char* name) { return folder_ / name; }

    std::string saved() {
        const auto model = problem_.make_model();
        Trainer trainer(*model, problem_.config.train, problem_.features, problem_.shapes);
        trainer.start();
        ModelContext context;
        context.config = "model: {}";
        context.reference = problem_.mesh;
        context.scale.factor.fill(2.0);
        context.scale.roots = roots_;
        context.train_shapes = problem_.shapes;
        const std::string path = temporary("model.safetensors");
        write_network(path, *model, context, trainer.state(), trainer.codes());
        return path;
    }
    SmallTraining problem_;
    std::vector<float> roots_;

  private:
    TemporaryFolder folder_;
};

TEST_F(ModelFileTest, KeepsItsContext) {
    const ModelFile file(saved());
    EXPECT_EQ(file.context().config, "model: {}");
    EXPECT_EQ(file.context().reference.vertices, problem_.mesh.vertices);
    EXPECT_EQ(file.context().reference.faces, problem_.mesh.faces);
    EXPECT_EQ(file.context().scale.factor[8], 2.0);
    EXPECT_EQ(file.context().train_shapes, problem_.shapes);
    EXPECT_EQ(file.codes().code_count, 3 + 6);
    EXPECT_EQ(file.codes().shape_count(), 12);
}

TEST_F(ModelFileTest, KeepsTheMetric) {
    EXPECT_TRUE(ModelFile(saved()).context().scale.roots.empty());
    for (int v = 0; v < problem_.mesh.vertex_count(); ++v) {
        roots_.push_back(1 + 0.01F * static_cast<float>(v));
    }
    EXPECT_EQ(ModelFile(saved()).context().scale.roots, roots_);
    roots_[7] = 0;
    EXPECT_THROW(ModelFile{saved()}, CheckpointError);
    roots_[7] = 1;
    EXPECT_NO_THROW(ModelFile{saved()});
    roots_.pop_back();
    EXPECT_THROW(ModelFile{saved()}, CheckpointError);
}

// Every array in the vertex order of the user, under its name.
TEST_F(ModelFileTest, HoldsArraysInTheOrderOfTheUser) {
    const auto model = problem_.make_model();
    Trainer trainer(*model, problem_.config.train, problem_.features, problem_.shapes);
    trainer.start();
    for (int epoch = 0; epoch < 2; ++epoch) trainer.run_epoch();
    ModelContext context;
    context.reference = problem_.mesh;
    context.train_shapes = problem_.shapes;
    const std::string path = temporary("model.safetensors");
    write_network(path, *model, context, trainer.state(), trainer.codes());
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

// Also where vertices have other than nine weights.
TEST_F(ModelFileTest, HoldsAnyNumberOfChannels) {
    for (const int channels : {1, 5, 12}) {
        problem_.config.spectral.components = 4;
        problem_.config.spectral.conv_channels = channels;
        const auto model = make_vae<float>(problem_), loaded = make_vae<float>(problem_);
        start_random(*model, 8);
        model->set_centers(0, {0, 1, 2, 3});
        ModelContext context;
        context.reference = problem_.mesh;
        context.train_shapes = problem_.shapes;
        const std::string path = temporary("model.safetensors");
        write_network(path, *model, context, {}, {4, std::vector<float>(12 * 4)});
        const SafetensorsFile file(path);
        const int weights = model->component_weights(0);
        EXPECT_TRUE(
            std::ranges::equal(file.data<float>("parameter/component_weights",
                                                {1, 4, problem_.mesh.vertex_count(), channels}),
                               model->to_user_order(weights, model->parameters().value(weights))));
        load_network(ModelFile(path), *loaded);
        EXPECT_TRUE(
            std::ranges::equal(loaded->parameters().all_values(), model->parameters().all_values()))
            << channels << " channels";
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
    load_network(file, *fresh);
    load_network(file, *used);
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
    Trainer trainer(*model, problem_.config.train, problem_.features, problem_.shapes);
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
    write_network(path, *model, context, trainer.state(), trainer.codes());
    const auto loaded = problem_.make_model();
    load_network(ModelFile(path), *loaded);
    EXPECT_EQ(loaded->acting(1), more);
}

// A settled centre need not be the longest vertex, so it is restored, not found again.
TEST_F(ModelFileTest, RestoresCentres) {
    const auto model = problem_.make_model();
    Trainer trainer(*model, problem_.config.train, problem_.features, problem_.shapes);
    trainer.start();
    const std::vector<int> coarse{5, 17, 160}, fine{9, 8, 7, 6, 5, 4};
    model->set_centers(0, coarse);
    model->set_centers(1, fine);
    ModelContext context;
    context.reference = problem_.mesh;
    context.train_shapes = problem_.shapes;
    CodeTable codes{9, std::vector<float>(12 * 9)};
    const std::string path = temporary("centres.safetensors");
    write_network(path, *model, context, trainer.state(), codes);
    const auto loaded = problem_.make_model();
    load_network(ModelFile(path), *loaded);
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
    CodeTable codes{9, std::vector<float>(12 * 9)};
    const std::string path = temporary("model.safetensors");
    const auto load = [&] {
        write_network(path, *model, context, {}, codes);
        const auto fresh = problem_.make_model();
        load_network(ModelFile(path), *fresh);
    };
    EXPECT_NO_THROW(load());
    std::swap(context.train_shapes[0], context.train_shapes[1]);
    EXPECT_THROW(load(), CheckpointError) << "shapes in disorder";
    context.train_shapes = problem_.shapes;
    codes.values.resize(11 * 9);
    EXPECT_THROW(load(), CheckpointError) << "a shape without codes";
    codes.values.resize(12 * 9);
    model->set_centers(0, {0, 1, -1});
    EXPECT_THROW(load(), CheckpointError) << "a component without centre";
    model->set_centers(0, {0, 1, 2});
    context.largest_distance = -1;
    EXPECT_THROW(load(), CheckpointError) << "a distance below zero";
    context.largest_distance = 1;
    EXPECT_NO_THROW(load());
    context.reference.faces.clear();
    EXPECT_THROW(load(), CheckpointError) << "no faces";
}

/// A copy of `file` at `path` in which the last number of `name` is `value`; an array `without` is
/// left out.
void write_changed(const SafetensorsFile& file, const std::string& path, const std::string& name,
                   double value, const std::string& without = "") {
    SafetensorsWriter writer;
    for (const auto& [key, text] : file.metadata()) {
        if (!key.starts_with("xxh3")) writer.set_metadata(key, text);
    }
    std::list<std::vector<double>> doubles;
    std::list<std::vector<float>> floats;
    for (const std::string& other : file.names()) {
        if (other == without) continue;
        const Shape& shape = file.shape(other);
        const bool is_changed = other == name;
        switch (file.type(other)) {
            case DataType::f32: {
                const auto data = file.data<float>(other, shape);
                floats.emplace_back(data.begin(), data.end());
                if (is_changed) floats.back().back() = static_cast<float>(value);
                writer.add<float>(other, shape, floats.back());
                break;
            }
            case DataType::f64: {
                const auto data = file.data<double>(other, shape);
                doubles.emplace_back(data.begin(), data.end());
                if (is_changed) doubles.back().back() = value;
                writer.add<double>(other, shape, doubles.back());
                break;
            }
            case DataType::i32:
                writer.add<int>(other, shape, file.data<int>(other, shape));
                break;
            default:
                writer.add<std::uint8_t>(other, shape, file.data<std::uint8_t>(other, shape));
        }
    }
    writer.write(path);
}

// Of whatever array: parameters, both moments, codes, state, scaler, mesh.
TEST_F(ModelFileTest, RefusesEveryArrayWithANumberThatIsNotFinite) {
    const SafetensorsFile file(saved());
    const std::string path = temporary("changed.safetensors");
    int arrays = 0;
    for (const std::string& name : file.names()) {
        if (file.type(name) != DataType::f32 && file.type(name) != DataType::f64) continue;
        ++arrays;
        for (const double value :
             {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
            write_changed(file, path, name, value);
            try {
                const ModelFile opened(path);
                FAIL() << name << " was read with " << value;
            } catch (const CheckpointError& error) {
                EXPECT_NE(std::string(error.what()).find(name + "["), std::string::npos)
                    << error.what();
            }
        }
    }
    EXPECT_GE(arrays, 3 * 12 + 4) << "parameters, their two moments, and what belongs to the run";
    write_changed(file, path, "", 0);
    EXPECT_NO_THROW(ModelFile{path}) << "the copy itself is sound";
}

// Nor is one ever written: the earlier file stays.
TEST_F(ModelFileTest, IsNeverWrittenWithANumberThatIsNotFinite) {
    const std::string path = saved();
    const std::string before = read_file(path);
    const auto model = problem_.make_model();
    ModelContext context;
    context.reference = problem_.mesh;
    context.train_shapes = problem_.shapes;
    const CodeTable codes{9, std::vector<float>(12 * 9)};
    const auto refused = [&](const std::string& name, const TrainingState& state,
                             const CodeTable& table) {
        try {
            write_network(path, *model, context, state, table);
            ADD_FAILURE() << name << " was written";
        } catch (const NumericalError& error) {
            EXPECT_NE(std::string(error.what()).find(name + "["), std::string::npos)
                << error.what();
        }
        EXPECT_EQ(read_file(path), before) << name;
    };
    ParameterSet<float>& parameters = model->parameters();
    for (int i = 0; i < parameters.count(); ++i) {
        for (const auto& [prefix, values] : {std::pair{"parameter/", parameters.value(i)},
                                             std::pair{"adam_m/", parameters.moment1(i)},
                                             std::pair{"adam_v/", parameters.moment2(i)}}) {
            values.back() = std::numeric_limits<float>::quiet_NaN();
            refused(prefix + parameters.entry(i).name, {}, codes);
            values.back() = 0;
        }
    }
    CodeTable broken = codes;
    broken.values.back() = std::numeric_limits<float>::infinity();
    refused("codes/level1", {}, broken);
    TrainingState state;
    state.total = std::numeric_limits<double>::infinity();
    refused("largest_distance_and_total", state, codes);
}

// The rate is part of the state; files from before it was have the full one.
TEST_F(ModelFileTest, KeepsTheFactorOfTheRate) {
    const std::string path = saved();
    EXPECT_EQ(ModelFile(path).state().rate_factor, 1);
    const auto model = problem_.make_model();
    ModelContext context;
    context.reference = problem_.mesh;
    context.train_shapes = problem_.shapes;
    TrainingState state;
    state.rate_factor = 0.25;
    state.first_error = 3.5;
    write_network(path, *model, context, state, {9, std::vector<float>(12 * 9)});
    EXPECT_EQ(ModelFile(path).state().rate_factor, 0.25);
    EXPECT_EQ(ModelFile(path).state().first_error, 3.5);
    write_changed(SafetensorsFile(path), temporary("old.safetensors"), "", 0, "divergence");
    EXPECT_EQ(ModelFile(temporary("old.safetensors")).state().rate_factor, 1);
    for (const double wrong : {0.0, -1.0, 2.0}) {
        state.rate_factor = wrong;
        write_network(path, *model, context, state, {9, std::vector<float>(12 * 9)});
        EXPECT_THROW(ModelFile{path}, CheckpointError) << wrong;
    }
}

TEST_F(ModelFileTest, RefusesAModelOfAnotherShape) {
    const ModelFile file(saved());
    problem_.config.stacked.levels[0].components = 4;
    const auto model = problem_.make_model();
    EXPECT_THROW(load_network(file, *model), CheckpointError);
}

}  // namespace
}  // namespace mscomp::nn

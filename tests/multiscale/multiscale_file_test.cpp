// SPDX-License-Identifier: MIT
// The model in its file, and what no file may make of it.
#include <gtest/gtest.h>

#include <functional>
#include <map>

#include "ball_cases.h"
#include "base/temporary_folder.h"
#include "mscomp/base/error.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/model/stored_arrays.h"
#include "multiscale/multiscale_model.h"

namespace mscomp {
namespace {

class MultiscaleFile : public testing::Test {
  protected:
    MultiscaleFile() {
        config_.kind = "multiscale";
        MultiscaleSettings settings;
        settings.global_components = 1;
        settings.levels = {{2, 0.4, 0.4}, {4, 0.3, 0.2}};
        config_.settings = settings;
        model_ = made();
        std::vector<Ball> balls{sphere_.ball(0, 1)};
        for (int k = 0; k < 6; ++k) balls.push_back(sphere_.ball(20 * k, k < 2 ? 0.4 : 0.2));
        BallComponents components(sphere_.vertices(), std::move(balls));
        const CounterRandom random(5, 0);
        for (std::size_t i = 0; i < components.all_values().size(); ++i) {
            components.all_values()[i] = static_cast<float>(random.normal(i));
        }
        model_->set_components(std::move(components));
    }
    std::unique_ptr<MultiscaleModel> made() {
        const ModelPlace place{sphere_.mesh, sphere_.distances, sphere_.scale};
        return std::make_unique<MultiscaleModel>(config_, place);
    }
    /// The arrays as `change` leaves them, loaded.
    std::unique_ptr<MultiscaleModel> loaded(
        const std::function<void(std::map<std::string, std::vector<std::int64_t>>&)>& change) {
        std::map<std::string, std::vector<std::int64_t>> arrays;
        std::vector<std::int64_t>& first = arrays["components/first"];
        first.push_back(0);
        std::vector<float> values;
        for (int k = 0; k < model_->code_count(); ++k) {
            const Ball& ball = model_->components().balls()[at(k)];
            arrays["components/centers"].push_back(ball.center);
            for (const int v : ball.vertices) arrays["components/vertices"].push_back(v);
            for (const float x : model_->components().component(k)) values.push_back(x);
            first.push_back(static_cast<std::int64_t>(arrays["components/vertices"].size()));
        }
        arrays["training/fill_up_to"] = {7};
        change(arrays);
        StoredArrays stored;
        for (auto& [name, numbers] : arrays) {
            const auto count = static_cast<std::int64_t>(numbers.size());
            if (name == "components/first") {
                stored.keep<std::int64_t>(name, {count}, numbers);
            } else {
                stored.keep<int>(name, {count}, {numbers.begin(), numbers.end()});
            }
        }
        const auto entries = static_cast<std::int64_t>(values.size()) / 9;
        stored.keep<float>("components/values", {entries, 9}, std::move(values));
        const std::string path = folder_ / "model.safetensors";
        stored.write(path, {});
        auto model = made();
        model->load(SafetensorsFile(path));
        return model;
    }

    cases::Sphere sphere_;
    Config config_;
    std::unique_ptr<MultiscaleModel> model_;
    TemporaryFolder folder_;
};

TEST_F(MultiscaleFile, HoldsTheComponents) {
    const auto model = loaded([](auto&) {});
    EXPECT_TRUE(cases::dense(model->components()) == cases::dense(model_->components()));
    EXPECT_EQ(model->parents(), model_->parents());
    EXPECT_EQ(model->fill_up_to, 7);
}

// Global components may be fewer than the configuration allows, never more.
TEST_F(MultiscaleFile, ArraysThatFitNoModelAreRefused) {
    using Arrays = std::map<std::string, std::vector<std::int64_t>>;
    const std::vector<std::function<void(Arrays&)>> changes{
        [](Arrays& a) { a["components/centers"][2] = 162; },
        [](Arrays& a) { a["components/centers"][2] = -1; },
        [](Arrays& a) { a["components/centers"].resize(5); },
        [](Arrays& a) { a["components/centers"].resize(9); },
        [](Arrays& a) { a["components/first"][0] = 1; },
        [](Arrays& a) { a["components/first"][3] = a["components/first"][2] - 1; },
        [](Arrays& a) { a["components/first"].back() -= 1; },
        [](Arrays& a) { a["components/first"][1] = std::int64_t{1} << 62; },
        [](Arrays& a) { std::swap(a["components/vertices"][3], a["components/vertices"][4]); },
        [](Arrays& a) { a["components/vertices"].back() = 162; },
        [](Arrays& a) { a["components/vertices"][0] = -1; },
        [](Arrays& a) { a["training/fill_up_to"] = {-1}; },
        [](Arrays& a) { a.erase("training/fill_up_to"); },
    };
    for (std::size_t i = 0; i < changes.size(); ++i) {
        // ModelFile makes a CheckpointError of either.
        EXPECT_THROW(loaded(changes[i]), Error) << i;
    }
}

// A state in space comes back as it was saved; one that no training leaves is refused.
TEST_F(MultiscaleFile, HoldsTheStateInSpace) {
    const std::size_t size = model_->components().all_values().size();
    const SpaceState sound{cases::random_matrix(7, 5, 1), std::vector<float>(size, 0.5F),
                           std::vector<float>(size, 0.25F), 75};
    const auto again = [&](const SpaceState& state) {
        model_->space_state = state;
        StoredArrays arrays;
        model_->save(arrays);
        const std::string path = folder_ / "space.safetensors";
        arrays.write(path, {});
        auto model = made();
        model->load(SafetensorsFile(path));
        return *model->space_state;
    };
    const SpaceState same = again(sound);
    EXPECT_TRUE(same.codes == sound.codes);
    EXPECT_EQ(same.moment1, sound.moment1);
    EXPECT_EQ(same.moment2, sound.moment2);
    EXPECT_EQ(same.steps, sound.steps);
    const auto refuses = [&](const std::function<void(SpaceState&)>& change) {
        SpaceState state = sound;
        change(state);
        EXPECT_THROW(again(state), CheckpointError);
    };
    refuses([](SpaceState& state) { state.steps = -1; });
    refuses([](SpaceState& state) { state.moment2[3] = -1e-9F; });
    refuses([](SpaceState& state) { state.codes.resize(7, 0); });
}

// The parent is the one of the level above that is overlapped most; global ones have no children.
TEST_F(MultiscaleFile, ParentsAreOverlappedMost) {
    const std::vector<int> parents = model_->parents();
    ASSERT_EQ(parents.size(), 7U);
    for (int k = 0; k < 3; ++k) EXPECT_EQ(parents[at(k)], -1) << k;
    const Eigen::MatrixXd shared = overlaps(model_->components());
    for (int k = 3; k < 7; ++k) {
        const int best = shared(k, 1) >= shared(k, 2) ? 1 : 2;
        EXPECT_EQ(parents[at(k)], shared(k, best) > 0 ? best : -1) << k;
    }
}

// Components that were begun with keep their parents, whatever they overlap.
TEST_F(MultiscaleFile, HoldsParentsThatWereGiven) {
    const auto again = [&](std::vector<int> parents) {
        model_->set_parents(std::move(parents));
        StoredArrays arrays;
        model_->save(arrays);
        const std::string path = folder_ / "parents.safetensors";
        arrays.write(path, {});
        auto model = made();
        model->load(SafetensorsFile(path));
        return model->parents();
    };
    const std::vector<int> given{-1, -1, 0, 2, 1, -1, 0};
    EXPECT_EQ(again(given), given);
    EXPECT_THROW(again({-1, -1, 0, 3, 1, -1, 0}), CheckpointError);  // of its own level
    EXPECT_THROW(again({-1, -1, -2, 2, 1, -1, 0}), CheckpointError);
    EXPECT_THROW(again({0, -1, 0, 2, 1, -1, 0}), CheckpointError);
}

// Codes of what codes decode to are these codes; the first levels are a sum of their own.
TEST_F(MultiscaleFile, EncodesWhatItDecodes) {
    std::vector<float> codes;
    for (int k = 0; k < 7; ++k) codes.push_back(0.1F * static_cast<float>(k - 3));
    const std::vector<float> row = model_->decode(codes);
    class One final : public ShapeSet {
      public:
        explicit One(const std::vector<float>& row) : row_(row) {}
        int shape_count() const override { return 1; }
        int vertex_count() const override { return static_cast<int>(row_.size()) / 9; }
        std::span<const float> shape(int) const override { return row_; }
        std::span<const float> vertices(int) const override { return {}; }
        void forget(int) const override {}

      private:
        const std::vector<float>& row_;
    } one(row);
    const std::vector<int> which{0};
    const CodeTable found = model_->encode(one, which);
    for (std::size_t k = 0; k < codes.size(); ++k) EXPECT_NEAR(found.values[k], codes[k], 1e-4);
    std::vector<float> coarse(codes);
    std::fill(coarse.begin() + 3, coarse.end(), 0.0F);
    EXPECT_EQ(model_->decode(codes, 2), model_->decode(coarse));
}

}  // namespace
}  // namespace mscomp

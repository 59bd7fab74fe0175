// SPDX-License-Identifier: MIT
// From features to units and back, what a file may hold, and what cannot be done.
#include "units/unit_model.h"

#include <gtest/gtest.h>

#include <numeric>

#include "base/temporary_folder.h"
#include "mscomp/base/error.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/model/stored_arrays.h"
#include "multiscale/ball_cases.h"
#include "units/planted_units.h"
#include "units/unit_learner.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;

/// Features (shapes,V,9) in memory.
class Features final : public ShapeSet {
  public:
    Features(int vertices, const MatrixXd& changes) : vertices_(vertices) {
        for (Eigen::Index i = 0; i < changes.size(); ++i) {
            values_.push_back(kReferenceFeature[at(i) % kFeatureDim] +
                              static_cast<float>(changes.data()[i]));
        }
    }
    int shape_count() const override { return static_cast<int>(values_.size()) / (9 * vertices_); }
    int vertex_count() const override { return vertices_; }
    std::span<const float> shape(int index) const override {
        return std::span(values_).subspan(9 * at(index * vertices_), 9 * at(vertices_));
    }
    std::span<const float> vertices(int) const override { return {}; }
    void forget(int) const override {}

  private:
    int vertices_;
    std::vector<float> values_;
};

class UnitModelTest : public testing::Test {
  protected:
    UnitModelTest() { config_.settings = UnitSettings{}; }
    std::unique_ptr<UnitModel> made() {
        return std::make_unique<UnitModel>(
            config_, ModelPlace{sphere_.mesh, sphere_.distances, sphere_.scale});
    }
    /// Four units on balls; `codes` (shapes,4).
    Features moved_by(const MatrixXd& codes) {
        const MatrixXd components = cases::dense(sphere_.components(4, 0.25, 37));
        return {sphere_.vertices(), 0.1 * components * codes.transpose()};
    }
    std::unique_ptr<Learner> started(UnitModel& model, const Features& shapes) {
        std::vector<int> train(at(shapes.shape_count()));
        std::iota(train.begin(), train.end(), 0);
        auto learner = model.learner(shapes, train);
        learner->start();
        return learner;
    }

    cases::Sphere sphere_;
    Config config_;
};

TEST_F(UnitModelTest, FindsTheUnitsOfFeaturesAndGivesShapesBack) {
    const MatrixXd codes = cases::switching_codes(40, 4);
    const Features shapes = moved_by(codes);
    const auto model = made();
    const auto learner = started(*model, shapes);
    ASSERT_EQ(model->code_count(), 4);
    ASSERT_EQ(learner->notes().size(), 1U);
    EXPECT_TRUE(learner->warnings().empty()) << learner->warnings().front();
    EXPECT_FALSE(learner->is_over());
    EXPECT_LT(learner->run_epoch().total, 1e-6);
    EXPECT_TRUE(learner->is_over());
    const CodeTable table = learner->codes();
    const MatrixXd found =
        Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
            table.values.data(), 40, 4)
            .cast<double>();
    EXPECT_GT(cases::nearest_cosines(codes, found).minCoeff(), 1 - 1e-4);
    const std::vector<float> row = model->decode(table.shape(7));
    for (std::size_t i = 0; i < row.size(); ++i) EXPECT_NEAR(row[i], shapes.shape(7)[i], 1e-4);
}

TEST_F(UnitModelTest, AtMostSoManyAreThoseThatMoveMost) {
    MatrixXd codes = cases::switching_codes(40, 4);
    codes.col(1) *= 4;
    codes.col(3) *= 3;
    config_.settings = UnitSettings{2};
    const auto model = made();
    const auto learner = started(*model, moved_by(codes));
    ASSERT_EQ(model->code_count(), 2);
    const auto centre = [&](int k) { return model->components().balls()[at(k)].center; };
    const auto planted = [&](int k) { return sphere_.components(4, 0.25, 37).balls()[at(k)]; };
    for (const auto& [unit, k] : {std::pair{0, 1}, {1, 3}}) {
        EXPECT_TRUE(std::ranges::binary_search(planted(k).vertices, centre(unit))) << k;
    }
}

TEST_F(UnitModelTest, SaysWhatIsMissing) {
    const auto message = [&](const MatrixXd& codes) -> std::string {
        try {
            started(*made(), moved_by(codes));
        } catch (const UsageError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_NE(message(MatrixXd::Ones(1, 4)).find("1 training shapes, wanted 12 at least"),
              std::string::npos);
    EXPECT_NE(message(MatrixXd::Zero(12, 4)).find("differs from the reference"), std::string::npos);
    EXPECT_NE(message(MatrixXd::Identity(16, 4)).find("agree on a unit"), std::string::npos);
}

TEST_F(UnitModelTest, AFileMustHoldWhatUnitsAre) {
    const auto model = made();
    model->set_units(sphere_.components(3, 0.3), {1, 2}, {{5, 1}, {3, 0.5}, {2, 0}});
    const auto loaded = [&](const std::vector<int>& levels, const std::vector<int>& votes,
                            const std::vector<double>& again) {
        const TemporaryFolder folder;
        std::vector<ComponentTrust> trust;
        for (std::size_t k = 0; k < votes.size(); ++k) trust.push_back({votes[k], again[k]});
        model->set_units(sphere_.components(3, 0.3), levels, trust);
        StoredArrays arrays;
        model->save(arrays);
        arrays.write(folder / "m.safetensors", {});
        auto result = made();
        result->load(SafetensorsFile(folder / "m.safetensors"));
        return result;
    };
    const auto sound = loaded({1, 2}, {5, 3, 2}, {1, 0.5, 0});
    EXPECT_EQ(sound->levels().size(), 2U);
    EXPECT_EQ(sound->code_count(), 3);
    EXPECT_EQ(sound->trust()[1].votes, 3);
    EXPECT_EQ(sound->trust()[1].found_again, 0.5);
    EXPECT_THROW(loaded({1, 2}, {5, -3, 2}, {1, 0.5, 0}), CheckpointError);
    EXPECT_THROW(loaded({1, 2}, {5, 3, 2}, {1, 1.5, 0}), CheckpointError);
    EXPECT_THROW(loaded({3, 0}, {5, 3, 2}, {1, 0.5, 0}), CheckpointError);
    config_.settings = UnitSettings{2};
    EXPECT_THROW(loaded({1, 2}, {5, 3, 2}, {1, 0.5, 0}), CheckpointError) << "three, wanted two";
    config_.settings = UnitSettings{};
    EXPECT_THROW(loaded({1, 1, 1}, {5, 3, 2}, {1, 0.5, 0}), CheckpointError);
}

}  // namespace
}  // namespace mscomp

// SPDX-License-Identifier: MIT
// From features to units and back, what a file may hold, and what cannot be done.
#include "units/unit_model.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numeric>

#include "base/temporary_folder.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/model/stored_arrays.h"
#include "multiscale/ball_cases.h"
#include "units/planted_units.h"
#include "units/unit_learner.h"

namespace mscomp {
namespace {

using cases::Features;
using cases::matrix_of;
using cases::started;
using Eigen::MatrixXd;

/// Positions (shapes,V,3) in memory, each shape turned and shifted by a little.
class Positions final : public ShapeSet {
  public:
    Positions(const TriangleMesh& mesh, const MatrixXd& changes)
        : vertices_(mesh.vertex_count()), shapes_(static_cast<int>(changes.cols())) {
        for (Eigen::Index m = 0; m < changes.cols(); ++m) {
            std::vector<Point> points = mesh.vertices;
            for (std::size_t i = 0; i < 3 * points.size(); ++i) {
                points[i / 3][i % 3] += changes(static_cast<Eigen::Index>(i), m);
            }
            RigidMotion motion;
            const double turn = 0.02 * static_cast<double>(m % 5 - 2);
            motion.rotation = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY());
            motion.translation.x() = turn;
            for (const Point& point : moved(points, motion)) {
                for (const double x : point) values_.push_back(static_cast<float>(x));
            }
        }
    }
    int shape_count() const override { return shapes_; }
    int vertex_count() const override { return vertices_; }
    std::span<const float> shape(int) const override { return {}; }
    std::span<const float> vertices(int index) const override {
        return std::span(values_).subspan(3 * at(index * vertices_), 3 * at(vertices_));
    }
    void forget(int) const override {}

  private:
    int vertices_, shapes_;
    std::vector<float> values_;
};

class UnitModelTest : public testing::Test {
  protected:
    UnitModelTest() { config_.settings = UnitSettings{0, ShapeRows::features, UnitRoute::codes}; }
    std::unique_ptr<UnitModel> made() {
        return std::make_unique<UnitModel>(
            config_, ModelPlace{sphere_.mesh, sphere_.distances, sphere_.scale});
    }
    /// Four units on balls; `codes` (shapes,4).
    Features moved_by(const MatrixXd& codes) {
        const MatrixXd components = cases::dense(sphere_.components(4, 0.25, 37));
        return {sphere_.vertices(), 0.1 * components * codes.transpose()};
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
    ASSERT_GE(learner->notes().size(), 1U);
    EXPECT_TRUE(learner->warnings().empty()) << learner->warnings().front();
    EXPECT_FALSE(learner->is_over());
    EXPECT_LT(learner->run_epoch().total, 1e-6);
    EXPECT_TRUE(learner->is_over());
    const CodeTable table = learner->codes();
    EXPECT_GT(cases::nearest_cosines(codes, matrix_of(table)).minCoeff(), 1 - 1e-4);
    const std::vector<float> row = model->decode(table.shape(7));
    for (std::size_t i = 0; i < row.size(); ++i) EXPECT_NEAR(row[i], shapes.shape(7)[i], 1e-4);
}

// However the shapes lie: a unit is where it moves something, and shapes come back in their form.
TEST_F(UnitModelTest, FindsTheUnitsOfPositionsWhereverTheShapesLie) {
    const MatrixXd codes = cases::switching_codes(60, 4);
    const BallComponents planted = sphere_.components(4, 0.25, 37, 3);
    const MatrixXd changes = 0.2 * cases::dense(planted) * codes.transpose();
    const Positions shapes(sphere_.mesh, changes);
    config_.settings = UnitSettings{0, ShapeRows::positions};
    const auto model = made();
    EXPECT_EQ(model->rows(), ShapeRows::positions);
    EXPECT_NEAR(model->unit(), 1, 1e-6);
    const auto learner = started(*model, shapes);
    ASSERT_EQ(model->code_count(), 4) << learner->notes().front();
    EXPECT_TRUE(learner->warnings().empty()) << learner->warnings().front();
    EXPECT_LT(learner->run_epoch().total, 1e-6);
    const CodeTable table = learner->codes();
    EXPECT_GT(cases::nearest_cosines(codes, matrix_of(table)).minCoeff(), 1 - 1e-4);
    std::vector<std::size_t> supports, wanted;
    for (int k = 0; k < 4; ++k) {
        supports.push_back(model->components().balls()[at(k)].vertices.size());
        wanted.push_back(planted.balls()[at(k)].vertices.size());
    }
    for (auto* sizes : {&supports, &wanted}) std::ranges::sort(*sizes);
    for (std::size_t k = 0; k < 4; ++k) {
        EXPECT_LE(supports[k], wanted[k]);
        EXPECT_GT(static_cast<double>(supports[k]), 0.9 * static_cast<double>(wanted[k]));
    }
    const std::vector<float> row = model->decode(table.shape(7));
    for (std::size_t i = 0; i < row.size(); ++i) {
        const double truth =
            sphere_.mesh.vertices[i / 3][i % 3] + changes(static_cast<Eigen::Index>(i), 7);
        EXPECT_NEAR(row[i], truth, 1e-3);
    }
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
    const auto loaded = [&](const std::vector<int>& levels, const std::vector<int>& votes,
                            const std::vector<double>& again) {
        const TemporaryFolder folder;
        std::vector<ComponentTrust> trust;
        for (std::size_t k = 0; k < votes.size(); ++k) trust.push_back({votes[k], again[k]});
        model->set_units({sphere_.components(3, 0.3), levels, trust, {}, {}});
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

// Three numbers at each vertex are positions, nine are features; neither is taken for the other.
TEST_F(UnitModelTest, AFileOfPositionsIsOneOfPositions) {
    const TemporaryFolder folder;
    config_.settings = UnitSettings{0, ShapeRows::positions};
    const auto model = made();
    model->set_units({sphere_.components(3, 0.3, 17, 3), {3}, {{5, 1}, {3, 0.5}, {2, 0}}, {}, {}});
    StoredArrays arrays;
    model->save(arrays);
    arrays.write(folder / "m.safetensors", {});
    const auto again = made();
    again->load(SafetensorsFile(folder / "m.safetensors"));
    const std::vector<float> codes{0.5F, -1, 2};
    EXPECT_EQ(again->decode(codes), model->decode(codes));
    config_.settings = UnitSettings{};
    const auto other = made();
    EXPECT_THROW(other->load(SafetensorsFile(folder / "m.safetensors")), InputError);
}

}  // namespace
}  // namespace mscomp

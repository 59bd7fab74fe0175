// SPDX-License-Identifier: MIT
// Models of units that turn: from features to codes and back through integrated rotations.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "acap/rotation.h"
#include "base/temporary_folder.h"
#include "mscomp/base/error.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/model/stored_arrays.h"
#include "multiscale/ball_cases.h"
#include "units/planted_units.h"
#include "units/unit_learner.h"
#include "units/unit_model.h"

namespace mscomp {
namespace {

using cases::Features;
using cases::matrix_of;
using cases::started;
using Eigen::MatrixXd;

constexpr int kJoints = 3, kShapes = 40;

/// A sphere whose slices turn against each other about z, by three joints that all move all the
/// time and stretch where they turn, by the square of how much they do.
class TurningModelTest : public testing::Test {
  protected:
    TurningModelTest() : codes_(cases::random_matrix(kShapes, kJoints, 3)) {
        config_.settings = UnitSettings{};
    }
    MatrixXd changes() const {
        const int vertices = sphere_.vertices();
        MatrixXd changes = MatrixXd::Zero(kFeatureDim * vertices, kShapes);
        for (int v = 0; v < vertices; ++v) {
            const double z = sphere_.mesh.vertices[at(v)][2];
            for (int k = 0; k < kJoints; ++k) {
                const double along = (z - (-0.65 + 0.65 * k)) / 0.15;
                const double turned = std::clamp(0.5 + along / 2, 0.0, 1.0);
                const double bulge = std::max(0.0, 1 - along * along);
                for (int m = 0; m < kShapes; ++m) {
                    const double code = codes_(m, k);
                    changes(kFeatureDim * v + 2, m) += 0.8 * code * turned;
                    changes(kFeatureDim * v + 3, m) += 0.02 * code * bulge;
                    changes(kFeatureDim * v + 8, m) += 0.03 * code * code * bulge;
                }
            }
        }
        return changes;
    }
    std::unique_ptr<UnitModel> made() {
        return std::make_unique<UnitModel>(
            config_, ModelPlace{sphere_.mesh, sphere_.distances, sphere_.scale});
    }

    cases::Sphere sphere_;
    MatrixXd codes_;
    Config config_;
};

TEST_F(TurningModelTest, FindsJointsWithoutBeingToldAndGivesShapesBack) {
    const Features shapes(sphere_.vertices(), changes());
    const auto model = made();
    const auto learner = started(*model, shapes);
    ASSERT_TRUE(model->is_turning());
    ASSERT_EQ(model->code_count(), kJoints) << learner->notes().front();
    EXPECT_TRUE(learner->warnings().empty());
    learner->run_epoch();
    const CodeTable table = learner->codes();
    EXPECT_GT(cases::nearest_cosines(codes_, matrix_of(table)).minCoeff(), 0.999);
    double most = 0;
    for (int m = 0; m < kShapes; ++m) {
        const std::vector<float> row = model->decode(table.shape(m));
        for (std::size_t i = 0; i < row.size(); ++i) {
            most = std::max(most, static_cast<double>(std::abs(row[i] - shapes.shape(m)[i])));
        }
    }
    EXPECT_LT(most, 0.05) << "of turns by more than a half";
    for (const ComponentTrust& trust : model->trust()) {
        EXPECT_GE(trust.votes, 3);
        EXPECT_EQ(trust.found_again, 1);
        EXPECT_GT(trust.held_out, 0.98);
    }
    // A joint is where it turns, not where it carries the rest of the mesh.
    for (const ComponentPlace& place : model->places()) {
        EXPECT_LT(place.support, 2 * sphere_.vertices() / 3);
    }
}

TEST_F(TurningModelTest, TheReferenceAndWhatIsTheSameAreExact) {
    const Features shapes(sphere_.vertices(), changes());
    const auto model = made();
    started(*model, shapes);
    const std::vector<float> row = model->decode(model->reference_codes());
    for (std::size_t i = 0; i < row.size(); ++i) {
        EXPECT_NEAR(row[i], kReferenceFeature[i % kFeatureDim], 1e-6);
    }
    const std::vector<float> codes{0.5F, -1, 2};
    for (const float x : model->change(codes, codes)) EXPECT_EQ(x, 0);
}

TEST_F(TurningModelTest, DerivativesAreThoseOfDifferences) {
    const Features shapes(sphere_.vertices(), changes());
    const auto model = made();
    started(*model, shapes);
    const std::vector<float> codes{0.5F, -0.5F, 0.75F};
    const std::vector<CodeColumn> columns = model->derivatives(codes);
    ASSERT_EQ(columns.size(), std::size_t{kJoints});
    constexpr float kStep = 1.0F / 64;
    for (std::size_t k = 0; k < kJoints; ++k) {
        std::vector<float> up = codes, down = codes;
        up[k] += kStep;
        down[k] -= kStep;
        std::vector<float> wanted = model->change(up, down);
        std::vector<float> found(wanted.size(), 0.0F);
        for (std::size_t n = 0; n < columns[k].vertices.size(); ++n) {
            std::copy_n(columns[k].values.begin() + static_cast<std::ptrdiff_t>(kFeatureDim * n),
                        kFeatureDim,
                        found.begin() +
                            static_cast<std::ptrdiff_t>(kFeatureDim * at(columns[k].vertices[n])));
        }
        for (std::size_t i = 0; i < found.size(); ++i) {
            EXPECT_NEAR(found[i], wanted[i] / (2 * kStep), 2e-3) << k << ", " << i;
        }
    }
}

// Codes are least squares over what turns carry in space, A R (x - Σ z_k B_k), with the rotations R
// that the shape itself has: those about other axes, and what no unit tells, matter.
TEST_F(TurningModelTest, CodesAreLeastSquaresOfWhatTurnsCarry) {
    TurnField field(sphere_.mesh);
    const auto edges = at(field.edge_count());
    std::vector<Ball> balls(2);
    for (std::size_t e = 0; e < edges; ++e) {
        const Point& p = sphere_.mesh.vertices[at(field.edges()[e][0])];
        if (std::abs(p[2]) < 0.5) balls[0].vertices.push_back(static_cast<int>(e));
        if (std::abs(p[0]) < 0.5) balls[1].vertices.push_back(static_cast<int>(e));
    }
    // Slices that turn about z, and others about x.
    BallComponents turns(field.edge_count(), balls, 3);
    for (int e = 0; e < field.edge_count(); ++e) {
        const auto& [i, j] = field.edges()[at(e)];
        const Point &p = sphere_.mesh.vertices[at(i)], &q = sphere_.mesh.vertices[at(j)];
        for (std::size_t a = 0; a < turns.at_vertex(e).size(); ++a) {
            const std::size_t axis = turns.at_vertex(e)[a] == 0 ? 2 : 0;
            turns.values(e)[3 * a + axis] = static_cast<float>(q[axis] - p[axis]);
        }
    }
    const TurningComponents turning(TurnField(sphere_.mesh), turns, MatrixXd::Zero(2, 3),
                                    {sphere_.vertices(), std::vector<Ball>(4)});
    // A shape with rotations by one and more that the units do not quite tell.
    std::vector<Eigen::Vector3d> told = turning.rotations(std::vector<float>{1.5F, 1.0F});
    std::vector<float> features(at(sphere_.vertices()) * kFeatureDim, 0.0F), vectors;
    const MatrixXd other = 0.2 * cases::random_matrix(3, sphere_.vertices(), 7);
    for (std::size_t v = 0; v < told.size(); ++v) {
        told[v] += other.col(static_cast<Eigen::Index>(v));
        for (std::size_t c = 0; c < 3; ++c) {
            features[v * kFeatureDim + c] = static_cast<float>(told[v][static_cast<int>(c)]);
            vectors.push_back(features[v * kFeatureDim + c]);
        }
    }
    const std::vector<float> own = field.turns_of(vectors);
    const auto left = [&](const Eigen::VectorXd& codes) {
        std::vector<Eigen::Vector3d> in_space(edges);
        for (std::size_t e = 0; e < edges; ++e) {
            Eigen::Vector3d turn =
                Eigen::Map<const Eigen::Vector3f>(own.data() + 3 * e).cast<double>();
            const auto acting = turns.at_vertex(static_cast<int>(e));
            for (std::size_t a = 0; a < acting.size(); ++a) {
                turn -= codes[acting[a]] * Eigen::Map<const Eigen::Vector3f>(
                                               turns.values(static_cast<int>(e)).data() + 3 * a)
                                               .cast<double>();
            }
            in_space[e] = rotation_exp(told[at(field.edges()[e][0])]) * turn;
        }
        double squares = 0;
        for (const Eigen::Vector3d& sum : field.added_up(in_space)) squares += sum.squaredNorm();
        return squares;
    };
    const Eigen::VectorXd codes = turning.codes_of(features);
    for (int k = 0; k < 2; ++k) {
        for (const double step : {-0.01, 0.01}) {
            Eigen::VectorXd moved = codes;
            moved[k] += step;
            EXPECT_GT(left(moved), left(codes)) << k << ", " << step;
        }
    }
}

TEST_F(TurningModelTest, AFileGivesTheSameModel) {
    const TemporaryFolder folder;
    const Features shapes(sphere_.vertices(), changes());
    const auto model = made();
    started(*model, shapes);
    const auto written = [&](const std::string& name) {
        StoredArrays arrays;
        model->save(arrays);
        arrays.write(folder / name, {});
        return SafetensorsFile(folder / name);
    };
    const auto again = made();
    again->load(written("m.safetensors"));
    const std::vector<float> codes{0.5F, -1, 0.75F};
    EXPECT_EQ(again->decode(codes), model->decode(codes));
    EXPECT_EQ(again->encode(shapes, std::vector<int>{7}).values,
              model->encode(shapes, std::vector<int>{7}).values);
    EXPECT_EQ(again->parents(), model->parents());
    EXPECT_EQ(again->trust()[2].held_out, model->trust()[2].held_out);
    // Units of another number than those that turn.
    model->set_units({sphere_.components(3, 0.3), {3}, model->trust(), {}, {}});
    const auto other = made();
    other->load(written("n.safetensors"));
    EXPECT_FALSE(other->is_turning());
}

TEST_F(TurningModelTest, AFileMustHoldAsManyJointsAsUnits) {
    const TemporaryFolder folder;
    const auto model = made();
    const auto loaded = [&](std::size_t units) {
        TurnField field(sphere_.mesh);
        BallComponents turns(field.edge_count(), std::vector<Ball>(2, Ball{3, {3, 4}}), 3);
        TurningComponents turning(std::move(field), std::move(turns), MatrixXd::Zero(2, 3),
                                  {sphere_.vertices(), std::vector<Ball>(4)});
        model->set_units({BallComponents(sphere_.vertices(), std::vector<Ball>(units)),
                          {static_cast<int>(units)},
                          std::vector<ComponentTrust>(units),
                          std::move(turning),
                          {}});
        StoredArrays arrays;
        model->save(arrays);
        arrays.write(folder / "m.safetensors", {});
        const auto result = made();
        result->load(SafetensorsFile(folder / "m.safetensors"));
        return result->is_turning();
    };
    EXPECT_TRUE(loaded(2));
    EXPECT_THROW(loaded(3), CheckpointError);
}

// Codes that are 0 or 1 say nothing of what lies between or beyond: no square is made up.
TEST_F(TurningModelTest, TwoValuesTellNoSquare) {
    codes_ = (codes_.array() > 0).cast<double>() + 0.001 * codes_.array();
    config_.settings = UnitSettings{0, ShapeRows::features, UnitRoute::space};
    const Features shapes(sphere_.vertices(), changes());
    const auto model = made();
    const auto learner = started(*model, shapes);
    const MatrixXd codes = matrix_of(learner->codes());
    for (int k = 0; k < model->code_count(); ++k) {
        std::vector<float> zero(at(model->code_count()), 0.0F), one = zero, back = zero;
        one[at(k)] = static_cast<float>(codes.col(k).cwiseAbs().maxCoeff());
        back[at(k)] = -one[at(k)];
        const std::vector<float> there = model->change(one, zero),
                                 other = model->change(back, zero);
        for (std::size_t i = 0; i < there.size(); ++i) {
            if (i % kFeatureDim < kRotationDim) continue;
            EXPECT_NEAR(other[i], -there[i], 1e-5) << k;
        }
    }
}

TEST_F(TurningModelTest, FewerAreTheStrongest) {
    codes_.col(0) *= 0.3;
    codes_.col(2) *= 0.7;
    config_.settings = UnitSettings{2};
    const Features shapes(sphere_.vertices(), changes());
    const auto model = made();
    const auto learner = started(*model, shapes);
    ASSERT_EQ(model->code_count(), 2);
    const Eigen::VectorXd cosines = cases::nearest_cosines(codes_, matrix_of(learner->codes()));
    EXPECT_GT(cosines[1], 0.99);
    EXPECT_GT(cosines[2], 0.99);
}

TEST_F(TurningModelTest, RoutesAreTakenWhereTheyAreAskedFor) {
    const Features shapes(sphere_.vertices(), changes());
    config_.settings = UnitSettings{0, ShapeRows::features, UnitRoute::codes};
    auto model = made();
    started(*model, shapes);
    EXPECT_FALSE(model->is_turning());
    config_.settings = UnitSettings{0, ShapeRows::features, UnitRoute::space};
    model = made();
    started(*model, shapes);
    EXPECT_TRUE(model->is_turning());
}

}  // namespace
}  // namespace mscomp

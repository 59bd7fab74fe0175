// SPDX-License-Identifier: MIT
#include "mscomp/edit/feature_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "base/thrown_message.h"
#include "edit_cases.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using namespace cases;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Weights of vertices that differ, mean 1.
/// The waves with a metric.
struct WeighedModel : WaveModel {
    using WaveModel::WaveModel;
    std::vector<float> roots;  // empty: none
};

std::vector<float> some_roots(int count) {
    std::vector<float> roots;
    for (int v = 0; v < count; ++v) roots.push_back(v % 4 == 0 ? 1.5F : 0.75F);
    return roots;
}

/// Features that no code decodes to.
std::vector<float> foreign_features(const WeighedModel& model) {
    std::vector<float> rows = model.decode(some_codes(3, 0.4));
    Draws draws(5);
    for (float& x : rows) x += static_cast<float>(0.1 * draws.next());
    return rows;
}

/// As the model decodes or as features are, scaled and weighed by hand.
VectorXd weighed(const std::vector<float>& rows, const std::vector<float>& roots) {
    VectorXd result(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const double w = roots.empty() ? 1 : static_cast<double>(roots[i / kFeatureDim]);
        result[static_cast<Eigen::Index>(i)] =
            w * wave_scale().factor[i % kFeatureDim] * static_cast<double>(rows[i]);
    }
    return result;
}

/// Root mean square of scaled and weighed differences.
double distance(const WeighedModel& model, const std::vector<float>& codes,
                const std::vector<float>& truth) {
    const VectorXd away = weighed(model.decode(codes), model.roots) - weighed(truth, model.roots);
    return std::sqrt(away.squaredNorm() / static_cast<double>(away.size()));
}

/// Of the linear model, whose differences are exact: a column for each code.
MatrixXd dense_columns(const WeighedModel& model) {
    std::vector<float> codes(WaveModel::kCodes, 0.0F);
    const VectorXd zero = weighed(model.decode(codes), model.roots);
    MatrixXd result(zero.size(), WaveModel::kCodes);
    for (Eigen::Index k = 0; k < result.cols(); ++k) {
        codes.assign(codes.size(), 0.0F);
        codes[at(k)] = 1;
        result.col(k) = weighed(model.decode(codes), model.roots) - zero;
    }
    return result;
}

FeatureFitOptions scaled_options(const std::vector<float>& roots = {}) {
    FeatureFitOptions options;
    options.scale = wave_scale();
    options.scale.roots = roots;
    return options;
}

/// As far as it goes.
FeatureFitOptions exact_options(const std::vector<float>& roots = {}) {
    FeatureFitOptions options = scaled_options(roots);
    options.ridge = 0;
    options.max_steps = 60;
    options.least_gain = 1e-12;
    return options;
}

struct FeatureFitCase {
    explicit FeatureFitCase(WaveModel::Kind kind, bool has_weights = false)
        : mesh(bumpy_sphere(2)), model(mesh, kind) {
        if (has_weights) model.roots = some_roots(mesh.vertex_count());
    }
    TriangleMesh mesh;
    WeighedModel model;
};

// z = z⁰ + (CᵀC + ε (tr/K) I)⁻¹ Cᵀ (x - C z⁰), C and x scaled and weighed: one step is all.
TEST(FeatureFit, OfALinearDecoderIsTheJointLeastSquares) {
    for (const bool has_weights : {false, true}) {
        for (const double ridge : {1e-7, 0.3}) {
            const FeatureFitCase f(WaveModel::Kind::linear, has_weights);
            const std::vector<float> truth = foreign_features(f.model);
            const std::vector<float> start = some_codes(8, 2);
            const MatrixXd C = dense_columns(f.model);
            const VectorXd away =
                weighed(truth, f.model.roots) - weighed(f.model.decode(start), f.model.roots);
            MatrixXd H = C.transpose() * C;
            H.diagonal().array() += ridge * H.trace() / static_cast<double>(C.cols());
            const VectorXd step = H.fullPivLu().solve(C.transpose() * away);
            FeatureFitOptions options = scaled_options(f.model.roots);
            options.ridge = ridge;
            const FittedCodes found = FeatureFit(f.model, options).fit(truth, start);
            for (std::size_t k = 0; k < start.size(); ++k) {
                const double wanted =
                    static_cast<double>(start[k]) + step[static_cast<Eigen::Index>(k)];
                EXPECT_NEAR(found.codes[k], wanted, 1e-5 * step.norm()) << k << " " << ridge;
            }
            EXPECT_TRUE(found.converged);
            EXPECT_LE(found.steps, 2);  // the second is rounding
            EXPECT_NEAR(found.initial_rms, distance(f.model, start, truth), 1e-9);
            EXPECT_NEAR(found.rms, distance(f.model, found.codes, truth), 1e-9);
        }
    }
}

TEST(FeatureFit, WeightsOfVerticesDecideWhatIsNear) {
    const FeatureFitCase even(WaveModel::Kind::linear), uneven(WaveModel::Kind::linear, true);
    const std::vector<float> truth = foreign_features(even.model), start(WaveModel::kCodes, 0.0F);
    const std::vector<float> a = FeatureFit(even.model, scaled_options()).fit(truth, start).codes;
    const std::vector<float> b =
        FeatureFit(uneven.model, scaled_options(uneven.model.roots)).fit(truth, start).codes;
    EXPECT_LT(distance(even.model, a, truth), distance(even.model, b, truth));
    EXPECT_LT(distance(uneven.model, b, truth), distance(uneven.model, a, truth));
}

TEST(FeatureFit, RecoversWhatTheDecoderCanMake) {
    const FeatureFitCase f(WaveModel::Kind::tanh, true);
    const std::vector<float> wanted = some_codes(1, 0.8);
    std::vector<float> start = wanted;
    for (std::size_t k = 0; k < start.size(); ++k) start[k] += some_codes(2, 0.5)[k];
    const FittedCodes found =
        FeatureFit(f.model, exact_options(f.model.roots)).fit(f.model.decode(wanted), start);
    EXPECT_GT(found.initial_rms, 1e-2);
    EXPECT_TRUE(found.rms <= 1e-6) << found.rms;
    for (std::size_t k = 0; k < start.size(); ++k) {
        EXPECT_NEAR(found.codes[k], wanted[k], 1e-5);
    }
    EXPECT_TRUE(found.converged);
}

// Whatever the start, each further step lowers error + ridge, and no more than max_steps are taken.
TEST(FeatureFit, ObjectiveNeverRisesAndStepsEnd) {
    for (const auto kind :
         {WaveModel::Kind::tanh, WaveModel::Kind::redundant, WaveModel::Kind::breaking}) {
        const FeatureFitCase f(kind, true);
        const std::vector<float> truth = foreign_features(f.model);
        for (std::uint64_t n = 0; n < 6; ++n) {
            const bool is_wild = n > 2 && kind != WaveModel::Kind::breaking;
            const std::vector<float> start = some_codes(10 + n, is_wild ? 6 : 0.4);
            double before = std::numeric_limits<double>::infinity();
            for (int steps = 0; steps <= 12; ++steps) {
                FeatureFitOptions options = scaled_options(f.model.roots);
                options.max_steps = steps;
                options.ridge = 0;  // then the objective is the error
                options.least_gain = 0;
                const FittedCodes found = FeatureFit(f.model, options).fit(truth, start);
                EXPECT_LE(found.steps, steps);
                EXPECT_TRUE(found.rms <= before) << n << ": " << found.rms << " after " << before;
                EXPECT_NEAR(found.rms, distance(f.model, found.codes, truth), 1e-9);
                before = found.rms;
                if (steps == 0) {
                    EXPECT_EQ(found.codes, start);
                }
            }
            const FittedCodes found =
                FeatureFit(f.model, scaled_options(f.model.roots)).fit(truth, start);
            EXPECT_LT(found.rms, found.initial_rms);
        }
    }
}

// At a minimum no code lowers the distance, to first order.
TEST(FeatureFit, EndsWhereNoCodeHelpsAnyMore) {
    const FeatureFitCase f(WaveModel::Kind::tanh, true);
    const std::vector<float> truth = foreign_features(f.model), start(WaveModel::kCodes, 0.0F);
    const auto steepest = [&](const std::vector<float>& codes) {
        double result = 0;
        for (std::size_t k = 0; k < codes.size(); ++k) {
            const auto moved_by = [&](float x) {
                std::vector<float> changed = codes;
                changed[k] += x;
                return std::pow(distance(f.model, changed, truth), 2);
            };
            result = std::max(result, std::abs(moved_by(0.01F) - moved_by(-0.01F)) / 0.02);
        }
        return result;
    };
    const FittedCodes found = FeatureFit(f.model, exact_options(f.model.roots)).fit(truth, start);
    EXPECT_TRUE(found.converged);
    EXPECT_GT(found.rms, 0.01);  // out of reach
    EXPECT_TRUE(steepest(found.codes) <= 1e-3 * steepest(start)) << steepest(found.codes);
}

// Two codes that do the same share what there is to do, one that does nothing stays.
TEST(FeatureFit, RedundantCodesStayDetermined) {
    const FeatureFitCase f(WaveModel::Kind::redundant);
    std::vector<float> start = some_codes(4, 0.3);
    start[1] = start[0];
    const FittedCodes found =
        FeatureFit(f.model, scaled_options(f.model.roots)).fit(foreign_features(f.model), start);
    EXPECT_NEAR(found.codes[0], found.codes[1], 1e-4);
    EXPECT_EQ(found.codes.back(), start.back());
    EXPECT_GT(std::abs(found.codes[0] - start[0]), 1e-3);
}

// Not finite beyond 1/2: the truth lies there, the fit does not go there.
TEST(FeatureFit, StaysWhereTheDecoderIsFinite) {
    const FeatureFitCase f(WaveModel::Kind::breaking), whole(WaveModel::Kind::tanh);
    const std::vector<float> truth =
        whole.model.decode(std::vector<float>(WaveModel::kCodes, 0.9F));
    const FittedCodes found =
        FeatureFit(f.model, scaled_options(f.model.roots)).fit(truth, std::vector<float>(7, 0.1F));
    EXPECT_LT(found.rms, found.initial_rms);
    for (const float z : found.codes) EXPECT_LE(std::abs(z), 0.5F);
}

// Against dense algebra over the columns that move.
TEST(FeatureFit, MovesOnlyTheCodesThatMayMove) {
    const FeatureFitCase f(WaveModel::Kind::linear, true);
    const std::vector<float> truth = foreign_features(f.model), start = some_codes(8, 1);
    const std::vector<int> moving{5, 0, 3};
    const FittedCodes found =
        FeatureFit(f.model, scaled_options(f.model.roots)).fit(truth, start, moving);
    const MatrixXd all = dense_columns(f.model);
    MatrixXd C(all.rows(), 3);
    for (int n = 0; n < 3; ++n) C.col(n) = all.col(moving[at(n)]);
    const VectorXd away =
        weighed(truth, f.model.roots) - weighed(f.model.decode(start), f.model.roots);
    const VectorXd step = C.colPivHouseholderQr().solve(away);
    std::vector<double> wanted(start.begin(), start.end());
    for (int n = 0; n < 3; ++n) wanted[at(moving[at(n)])] += step[n];
    for (const int k : {1, 2, 4, 6}) EXPECT_EQ(found.codes[at(k)], start[at(k)]);
    for (const int k : {0, 3, 5}) EXPECT_NEAR(found.codes[at(k)], wanted[at(k)], 1e-4);
}

TEST(FeatureFit, IsTheSameForAnyNumberOfThreadsAloneAndTogether) {
    const FeatureFitCase f(WaveModel::Kind::tanh, true);
    const FeatureFit fit(f.model, scaled_options(f.model.roots));
    const std::vector<float> truth = foreign_features(f.model);
    const auto of_start = [&](std::int64_t n) {
        return fit.fit(truth, some_codes(static_cast<std::uint64_t>(20 + n), 0.5)).codes;
    };
    set_thread_count(1);
    std::vector<std::vector<float>> wanted;
    for (std::int64_t n = 0; n < 6; ++n) wanted.push_back(of_start(n));
    for (const int threads : {1, 2, 7}) {
        set_thread_count(threads);
        std::vector<std::vector<float>> found(6);
        parallel_for(6, [&](std::int64_t n) { found[at(n)] = of_start(n); });
        EXPECT_EQ(found, wanted) << threads;
        EXPECT_EQ(of_start(2), wanted[2]);
    }
    set_thread_count(0);
}

/// Decodes to positions.
class PositionModel final : public ShapeModel {
  public:
    ShapeRows rows() const override { return ShapeRows::positions; }
    int vertex_count() const override { return 3; }
    std::vector<LevelSize> levels() const override { return {{1, 1}}; }
    CodeTable encode(const ShapeSet&, std::span<const int>) override { return {}; }
    std::vector<float> reference_codes() override { return {}; }
    std::vector<float> decode(std::span<const float>, int) const override { return {}; }
    std::vector<float> change(std::span<const float>, std::span<const float>) const override {
        return {};
    }
    std::vector<CodeColumn> derivatives(std::span<const float>) const override { return {}; }
    std::vector<ComponentPlace> places() const override { return {}; }
};

TEST(FeatureFit, RefusesWhatDoesNotFit) {
    const FeatureFitCase f(WaveModel::Kind::breaking);
    const FeatureFit fit(f.model, scaled_options(f.model.roots));
    std::vector<float> truth = foreign_features(f.model), start(WaveModel::kCodes, 0.1F);
    EXPECT_THROW(fit.fit(std::span<const float>(truth).first(9), start), MeshError);
    EXPECT_THROW(fit.fit(truth, std::span<const float>(start).first(6)), UsageError);
    EXPECT_EQ(thrown_message<UsageError>([&] { fit.fit(truth, start, std::vector<int>{7}); }),
              "a fit of code 7, wanted 0 to 6");
    EXPECT_THROW(FeatureFit{PositionModel()}, UsageError);
    start[2] = 0.7F;
    EXPECT_EQ(thrown_message<NumericalError>([&] { fit.fit(truth, start); }),
              "the codes to start from decode to features that are not finite");
    start[2] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(thrown_message<NumericalError>([&] { fit.fit(truth, start); }),
              "a code to start from is not finite");
    start[2] = 0;
    truth[30] = std::numeric_limits<float>::infinity();
    EXPECT_EQ(thrown_message<NumericalError>([&] { fit.fit(truth, start); }),
              "the features of the shape to fit are not finite at vertex 3");
}

}  // namespace
}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/edit/vertex_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "acap/acap_cases.h"
#include "base/thrown_message.h"
#include "edit_cases.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using namespace cases;

std::vector<float> plus(std::vector<float> codes, const std::vector<float>& change) {
    for (std::size_t k = 0; k < codes.size(); ++k) codes[k] += change[k];
    return codes;
}

/// Root mean square of a coordinate after the best rigid motion of `points` to `truth`.
double distance(const std::vector<Point>& points, const std::vector<Point>& truth) {
    const std::vector<Point> aligned = moved(points, best_rigid_motion(points, truth));
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        sum += (vec(aligned[i]) - vec(truth[i])).squaredNorm();
    }
    return std::sqrt(sum / (3.0 * static_cast<double>(truth.size())));
}

double difference(const std::vector<Point>& a, const std::vector<Point>& b) {
    double result = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        result = std::max(result, largest(vec(a[i]) - vec(b[i])));
    }
    return result;
}

/// A rigid motion far away.
RigidMotion some_motion() { return {rotation_about({1, 2, -0.5}, 2.5), Vector3d(3, -8, 20)}; }

/// A shape that the model cannot reach.
std::vector<Point> foreign_shape(const TriangleMesh& mesh, double strength = 1) {
    return mapped(mesh,
                  [=](const Vector3d& p) -> Vector3d { return p + strength * (wobble(p) - p); })
        .vertices;
}

VertexFitOptions without_prior(VertexSolver solver = VertexSolver::poisson) {
    VertexFitOptions options;
    options.solver = solver;
    options.prior = 0;
    options.max_steps = 60;
    options.least_gain = 1e-9;
    return options;
}

struct Fixture {
    explicit Fixture(TriangleMesh reference = bumpy_sphere(2),
                     WaveModel::Kind kind = WaveModel::Kind::tanh)
        : mesh(std::move(reference)), model(mesh, kind) {}
    VertexFit fit(const VertexFitOptions& options) const {
        return {model, mesh, EdgeWeights::cotangent, options};
    }

    TriangleMesh mesh;
    WaveModel model;
};

// Codes and model on a grid that float holds exactly: only the h⁴ of the differences is left. At
// the code 0 every r is 0; elsewhere they go up to several turns.
TEST(VertexFit, DerivativesAreThoseOfThePositions) {
    constexpr float h = 1.0F / 64;
    for (const TriangleMesh& mesh : {bumpy_sphere(2), shapes::grid(7, 6)}) {
        const Fixture f(mesh, WaveModel::Kind::linear);
        const VertexFit fit = f.fit({});
        const std::size_t count = mesh.vertices.size();
        for (const double size : {0.0, 0.5, 4.0}) {
            std::vector<float> codes = some_codes(1, size);
            for (float& z : codes) z = std::round(32 * z) / 32;
            const std::vector<double> found = fit.derivatives(codes);
            ASSERT_EQ(found.size(), codes.size() * count * 3);
            for (std::size_t k = 0; k < codes.size(); ++k) {
                const auto solved = [&](float x) {
                    std::vector<float> changed = codes;
                    changed[k] += x;
                    return fit.positions(changed);
                };
                const auto a = solved(h), b = solved(-h), c = solved(2 * h), d = solved(-2 * h);
                double error = 0, range = 0;
                for (std::size_t i = 0; i < count; ++i) {
                    const Vector3d slope =
                        (8 * (vec(a[i]) - vec(b[i])) - (vec(c[i]) - vec(d[i]))) / (12 * double{h});
                    const Eigen::Map<const Vector3d> ours(found.data() + 3 * (k * count + i));
                    error = std::max(error, largest(ours - slope));
                    range = std::max(range, largest(slope));
                }
                EXPECT_TRUE(error <= 1e-6 * range) << k << ": " << error << " of " << range;
                EXPECT_GT(range, 1e-3);
            }
        }
    }
}

// Whatever the model can make, moved rigidly anywhere, is found again from nearby codes.
TEST(VertexFit, RecoversWhatTheDecoderCanMake) {
    const Fixture f;
    for (const VertexSolver solver : {VertexSolver::poisson, VertexSolver::lossless}) {
        const VertexFit fit = f.fit(without_prior(solver));
        const std::vector<float> wanted = some_codes(1, 0.8);
        const std::vector<Point> truth = moved(fit.positions(wanted), some_motion());
        const FittedShape found = fit.fit(truth, plus(wanted, some_codes(2, 0.3)));
        EXPECT_GT(found.initial_rms, 0.01);
        EXPECT_TRUE(found.rms <= 1e-6) << found.rms;
        EXPECT_LT(difference(found.vertices, truth), 1e-5);
        EXPECT_TRUE(found.converged);
    }
}

// What it says is what its codes give; and the objective at the start is the error there, of which
// the end has no more.
TEST(VertexFit, IsNeverWorseThanItsStart) {
    const Fixture f;
    for (const VertexSolver solver : {VertexSolver::poisson, VertexSolver::lossless}) {
        for (const double prior : {0.0, 1e-3, 10.0}) {
            VertexFitOptions options;
            options.solver = solver;
            options.prior = prior;
            options.max_steps = 4;
            const VertexFit fit = f.fit(options);
            for (std::uint64_t n = 0; n < 6; ++n) {
                // The last starts are wild, and no shape is like the last truths.
                const std::vector<float> start = some_codes(10 + n, n < 3 ? 0.5 : 8);
                std::vector<Point> truth = foreign_shape(f.mesh, n % 2 == 0 ? 1 : 3);
                Draws draws(40 + n);
                for (Point& p : truth) p[1] += 0.1 * draws.next();
                const FittedShape found = fit.fit(truth, start);
                const double before = distance(fit.positions(start), truth);
                const double after = distance(fit.positions(found.codes), truth);
                // Where the descent of the lossless solver stops is a matter of rounding.
                const double tolerance = solver == VertexSolver::poisson ? 1e-12 : 1e-3 * before;
                EXPECT_NEAR(found.initial_rms, before, tolerance);
                EXPECT_NEAR(found.rms, after, tolerance);
                EXPECT_TRUE(found.rms <= found.initial_rms) << to_string(solver) << " " << n;
                double stated = 0;
                for (std::size_t i = 0; i < truth.size(); ++i) {
                    stated += (vec(found.vertices[i]) - vec(truth[i])).squaredNorm();
                }
                EXPECT_NEAR(std::sqrt(stated / (3.0 * static_cast<double>(truth.size()))),
                            found.rms, 1e-12);
            }
        }
    }
}

// At a minimum over codes and motions no code lowers the distance, to first order.
TEST(VertexFit, EndsWhereNoCodeHelpsAnyMore) {
    const Fixture f;
    const VertexFit fit = f.fit(without_prior());
    const std::vector<Point> truth = foreign_shape(f.mesh);
    const std::vector<float> start(WaveModel::kCodes, 0.0F);
    const auto slopes = [&](const std::vector<float>& codes) {
        std::vector<double> result;
        for (std::size_t k = 0; k < codes.size(); ++k) {
            const auto at_change = [&](float x) {
                std::vector<float> changed = codes;
                changed[k] += x;
                return std::pow(distance(fit.positions(changed), truth), 2);
            };
            result.push_back((at_change(0.02F) - at_change(-0.02F)) / 0.04);
        }
        return result;
    };
    const FittedShape found = fit.fit(truth, start);
    EXPECT_TRUE(found.converged);
    EXPECT_LT(found.rms, 0.8 * found.initial_rms);
    EXPECT_GT(found.rms, 0.01);  // out of reach
    double before = 0, after = 0;
    for (const double slope : slopes(start)) before = std::max(before, std::abs(slope));
    for (const double slope : slopes(found.codes)) after = std::max(after, std::abs(slope));
    EXPECT_TRUE(after <= 2e-3 * before) << after << " of " << before;
}

TEST(VertexFit, DoesNotDependOnWhereTheShapeStands) {
    const Fixture f;
    const VertexFit fit = f.fit({});
    const std::vector<Point> truth = foreign_shape(f.mesh);
    const std::vector<float> start = some_codes(4, 0.3);
    const FittedShape here = fit.fit(truth, start);
    const FittedShape there = fit.fit(moved(truth, some_motion()), start);
    EXPECT_GT(here.steps, 1);
    for (std::size_t k = 0; k < start.size(); ++k) {
        EXPECT_NEAR(here.codes[k], there.codes[k], 1e-4);
    }
    EXPECT_LT(difference(moved(here.vertices, some_motion()), there.vertices), 1e-4);
}

TEST(VertexFit, DoesNotDependOnTheUnit) {
    const Fixture f;
    const std::vector<float> start = some_codes(4, 0.3);
    const FittedShape one = f.fit({}).fit(foreign_shape(f.mesh), start);
    for (const double unit : {1e-6, 1e6}) {
        const auto scaled = [=](const Vector3d& p) -> Vector3d { return unit * p; };
        const Fixture g(mapped(f.mesh, scaled));
        TriangleMesh truth{foreign_shape(f.mesh), f.mesh.faces};
        const FittedShape other = g.fit({}).fit(mapped(truth, scaled).vertices, start);
        EXPECT_NEAR(other.rms / unit, one.rms, 1e-5 * one.rms);
        for (std::size_t k = 0; k < start.size(); ++k) {
            EXPECT_NEAR(one.codes[k], other.codes[k], 1e-3);
        }
    }
}

// How parts lie to each other comes from the codes: a part that lies elsewhere is an error.
TEST(VertexFit, SeesAPartThatLiesElsewhere) {
    TriangleMesh mesh = bumpy_sphere(1);
    const int half = mesh.vertex_count();
    for (int i = 0; i < half; ++i) {
        const Point p = mesh.vertices[at(i)];
        mesh.vertices.push_back({p[0] + 4, p[1], p[2]});
    }
    const std::vector<Face> faces = mesh.faces;
    for (const Face& t : faces) mesh.faces.push_back({t[0] + half, t[1] + half, t[2] + half});
    const Fixture f(mesh);
    const VertexFit fit = f.fit(without_prior());
    const std::vector<float> wanted = some_codes(1, 0.8);
    const std::vector<float> start = plus(wanted, some_codes(2, 0.1));
    const std::vector<Point> whole = moved(fit.positions(wanted), some_motion());
    const FittedShape found = fit.fit(whole, start);
    EXPECT_GT(found.initial_rms, 0.005);
    EXPECT_TRUE(found.rms <= 1e-6) << found.rms;
    EXPECT_LT(difference(found.vertices, whole), 1e-5);
    std::vector<Point> apart = whole;
    for (int i = half; i < 2 * half; ++i) apart[at(i)][2] += 1.5;
    EXPECT_GT(fit.fit(apart, start).rms, 0.05);
}

TEST(VertexFit, AStrongerPriorStaysNearerToTheStart) {
    const Fixture f;
    const std::vector<float> start = some_codes(4, 0.3);
    double last = std::numeric_limits<double>::infinity();
    for (const double prior : {0.0, 0.02, 0.2, 1e4}) {
        VertexFitOptions options = without_prior();
        options.prior = prior;
        const FittedShape found = f.fit(options).fit(foreign_shape(f.mesh), start);
        double away = 0;
        for (std::size_t k = 0; k < start.size(); ++k) {
            away += std::pow(double{found.codes[k]} - double{start[k]}, 2);
        }
        EXPECT_LT(away, last) << prior;
        last = away;
    }
    EXPECT_LT(last, 1e-10);
}

// Twice the deviations are half the prior.
TEST(VertexFit, PriorCountsInDeviations) {
    const Fixture f;
    const std::vector<float> start = some_codes(4, 0.3);
    VertexFitOptions plain = without_prior(), wide = without_prior();
    plain.prior = 0.02;
    wide.prior = 0.04;
    wide.code_deviations.assign(WaveModel::kCodes, 2);
    const FittedShape a = f.fit(plain).fit(foreign_shape(f.mesh), start);
    const FittedShape b = f.fit(wide).fit(foreign_shape(f.mesh), start);
    EXPECT_EQ(a.codes, b.codes);
    // The others count as the root mean square of all; the first has more room than that.
    wide.code_deviations[0] = 20;
    plain.code_deviations.assign(WaveModel::kCodes, std::sqrt((6 * 4.0F + 400) / 7));
    wide.prior = plain.prior = 0.5;
    const float far = f.fit(wide).fit(foreign_shape(f.mesh), start).codes[0];
    const float near = f.fit(plain).fit(foreign_shape(f.mesh), start).codes[0];
    EXPECT_GT(std::abs(far - start[0]), 1.1F * std::abs(near - start[0]));
}

// Codes that do nothing or the same leave the normal matrix singular.
TEST(VertexFit, SurvivesCodesThatDoNothingOrTheSame) {
    const Fixture f(bumpy_sphere(2), WaveModel::Kind::redundant);
    const VertexFit fit = f.fit(without_prior());
    const FittedShape found =
        fit.fit(foreign_shape(f.mesh), std::vector<float>(WaveModel::kCodes, 0.0F));
    EXPECT_LT(found.rms, 0.95 * found.initial_rms);
    EXPECT_NEAR(found.codes[0], found.codes[1], 1e-3);
    for (const float z : found.codes) EXPECT_TRUE(std::isfinite(z));
    EXPECT_EQ(found.codes.back(), 0.0F);
}

TEST(VertexFit, IsTheSameForAnyNumberOfThreadsAloneAndTogether) {
    const Fixture f;
    const VertexFit fit = f.fit({});
    std::vector<std::vector<Point>> truths;
    std::vector<float> starts;
    for (std::uint64_t n = 0; n < 3; ++n) {
        truths.push_back(foreign_shape(f.mesh, 0.5 + 0.3 * static_cast<double>(n)));
        for (const float z : some_codes(20 + n, 0.3)) starts.push_back(z);
    }
    const int before = thread_count();
    set_thread_count(1);
    std::vector<FittedShape> one;
    for (std::size_t n = 0; n < 3; ++n) {
        one.push_back(fit.fit(truths[n], std::span<const float>(starts).subspan(
                                             n * WaveModel::kCodes, WaveModel::kCodes)));
    }
    for (const int threads : {2, 7}) {
        set_thread_count(threads);
        const std::vector<FittedShape> all = fit.fit(truths, starts);
        for (std::size_t n = 0; n < 3; ++n) {
            EXPECT_EQ(all[n].codes, one[n].codes) << threads;
            EXPECT_EQ(all[n].vertices, one[n].vertices) << threads;
            EXPECT_EQ(all[n].rms, one[n].rms) << threads;
        }
        // One shape has the threads for its derivatives.
        EXPECT_EQ(fit.fit(truths[0], std::span<const float>(starts).first(WaveModel::kCodes)).codes,
                  one[0].codes);
    }
    set_thread_count(before);
}

TEST(VertexFit, WithoutStepsGivesTheStartBack) {
    const Fixture f;
    VertexFitOptions options;
    options.max_steps = 0;
    const std::vector<float> start = some_codes(4, 0.3);
    const FittedShape found = f.fit(options).fit(foreign_shape(f.mesh), start);
    EXPECT_EQ(found.codes, start);
    EXPECT_EQ(found.rms, found.initial_rms);
    EXPECT_EQ(found.steps, 0);
    EXPECT_FALSE(found.converged);
}

TEST(VertexFit, RefusesWhatDoesNotFit) {
    const Fixture f;
    const VertexFit fit = f.fit({});
    std::vector<Point> truth = foreign_shape(f.mesh);
    std::vector<float> start = some_codes(4, 0.3);
    const auto call = [&] { fit.fit(truth, start); };
    truth[7][2] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(thrown_message<NumericalError>(call), "vertex 7 of the shape to fit is not finite");
    truth.pop_back();
    EXPECT_EQ(thrown_message<MeshError>(call), "a shape of 161 vertices to fit, wanted 162");
    truth = foreign_shape(f.mesh);
    start[1] = std::numeric_limits<float>::infinity();
    EXPECT_EQ(thrown_message<NumericalError>(call), "a code to start from is not finite");
    start.pop_back();
    EXPECT_EQ(thrown_message<UsageError>(call), "6 codes to start from, wanted 7");
    EXPECT_THROW(fit.fit(std::vector<std::vector<Point>>{truth}, start), UsageError);
    VertexFitOptions options;
    options.code_deviations.assign(3, 1);
    EXPECT_EQ(thrown_message<UsageError>([&] { f.fit(options); }),
              "deviations of 3 codes, wanted 7");
    const Fixture other(bumpy_sphere(1));
    EXPECT_EQ(
        thrown_message<UsageError>([&] { VertexFit(other.model, f.mesh, EdgeWeights::cotangent); }),
        "a model of 42 vertices, wanted the 162 of the reference");
    EXPECT_THROW(parse_vertex_solver("none"), UsageError);
    for (const VertexSolver solver : {VertexSolver::poisson, VertexSolver::lossless}) {
        EXPECT_EQ(parse_vertex_solver(to_string(solver)), solver);
    }
}

// Steps into what cannot be decoded are refused; a start there is an error.
TEST(VertexFit, StaysWhereTheDecoderIsFinite) {
    const Fixture f(bumpy_sphere(2), WaveModel::Kind::breaking);
    const VertexFit fit = f.fit(without_prior());
    std::vector<float> start(WaveModel::kCodes, 0.0F);
    const FittedShape found = fit.fit(foreign_shape(f.mesh), start);
    EXPECT_LT(found.rms, found.initial_rms);
    start[0] = 100;
    EXPECT_THROW(fit.fit(foreign_shape(f.mesh), start), NumericalError);
}

}  // namespace
}  // namespace mscomp

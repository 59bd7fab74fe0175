// SPDX-License-Identifier: MIT
// Fits of some codes to some vertices.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "acap/acap_cases.h"
#include "base/thrown_message.h"
#include "edit_cases.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"
#include "mscomp/edit/vertex_fit.h"

namespace mscomp {
namespace {

using namespace cases;

VertexFit exact_fit(const WaveModel& model, const TriangleMesh& mesh, VertexSolver solver) {
    VertexFitOptions options;
    options.solver = solver;
    options.prior = 0;
    options.max_steps = 80;
    options.least_gain = 1e-9;
    return {model, mesh, EdgeWeights::cotangent, options};
}

/// The truth with nothing known but `vertices`.
std::vector<Point> only(const std::vector<Point>& truth, const std::vector<int>& vertices) {
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    std::vector<Point> result(truth.size(), Point{unknown, unknown, unknown});
    for (const int v : vertices) result[at(v)] = truth[at(v)];
    return result;
}

/// Every `step`-th vertex of the first `count`.
std::vector<int> every(int step, int count) {
    std::vector<int> result;
    for (int v = 0; v < count; v += step) result.push_back(v);
    return result;
}

double mean_square(const std::vector<Point>& points, const std::vector<Point>& truth,
                   const std::vector<int>& vertices) {
    std::vector<Point> p, q;
    for (const int v : vertices) {
        p.push_back(points[at(v)]);
        q.push_back(truth[at(v)]);
    }
    p = moved(p, best_rigid_motion(p, q));
    double sum = 0;
    for (std::size_t i = 0; i < p.size(); ++i) sum += (vec(p[i]) - vec(q[i])).squaredNorm();
    return sum / (3.0 * static_cast<double>(p.size()));
}

TriangleMesh two_spheres() {
    TriangleMesh mesh = bumpy_sphere(1);
    const int half = mesh.vertex_count();
    for (int i = 0; i < half; ++i) {
        const Point p = mesh.vertices[at(i)];
        mesh.vertices.push_back({p[0] + 4, p[1], p[2]});
    }
    const std::vector<Face> faces = mesh.faces;
    for (const Face& t : faces) mesh.faces.push_back({t[0] + half, t[1] + half, t[2] + half});
    return mesh;
}

const RigidMotion kMotion{rotation_about({1, 2, -0.5}, 2.5), Vector3d(3, -8, 20)};

// A shape that the model can make is known from some of its vertices: 3 x 21 numbers fix seven
// codes and a motion. The others come along.
TEST(FitSubset, RecoversAShapeFromSomeOfItsVertices) {
    const TriangleMesh mesh = bumpy_sphere(2);
    const WaveModel model(mesh, WaveModel::Kind::tanh);
    for (const VertexSolver solver : {VertexSolver::poisson, VertexSolver::lossless}) {
        const VertexFit fit = exact_fit(model, mesh, solver);
        const std::vector<float> wanted = some_codes(1, 0.8);
        const std::vector<Point> truth = moved(fit.positions(wanted), kMotion);
        std::vector<float> start = wanted;
        for (std::size_t k = 0; k < start.size(); ++k) start[k] += some_codes(2, 0.2)[k];
        const FitSubset subset{{}, every(8, mesh.vertex_count())};
        const FittedShape found = fit.fit(only(truth, subset.vertices), start, subset);
        EXPECT_GT(found.initial_rms, 0.005);
        EXPECT_TRUE(found.rms <= 1e-6) << found.rms;
        for (std::size_t i = 0; i < truth.size(); ++i) {
            ASSERT_TRUE((vec(found.vertices[i]) - vec(truth[i])).norm() <= 1e-4) << i;
        }
    }
}

// Where the truth is out of reach the end is a minimum over the codes that may move, measured at
// the vertices that are known, and the others have not moved by a bit.
TEST(FitSubset, EndsWhereNoneOfItsCodesHelpsAnyMore) {
    const TriangleMesh mesh = bumpy_sphere(2);
    const WaveModel model(mesh, WaveModel::Kind::tanh);
    const VertexFit fit = exact_fit(model, mesh, VertexSolver::poisson);
    const std::vector<Point> truth =
        mapped(mesh, [](const Vector3d& p) -> Vector3d { return wobble(p); }).vertices;
    const std::vector<float> start = some_codes(5, 0.2);
    const FitSubset subset{{5, 0, 3}, every(5, mesh.vertex_count())};
    const FittedShape found = fit.fit(only(truth, subset.vertices), start, subset);
    const auto slope = [&](const std::vector<float>& codes, int code) {
        const auto at_change = [&](float x) {
            std::vector<float> changed = codes;
            changed[at(code)] += x;
            return mean_square(fit.positions(changed), truth, subset.vertices);
        };
        return (at_change(0.02F) - at_change(-0.02F)) / 0.04;
    };
    double before = 0, after = 0, others = 0;
    for (int k = 0; k < WaveModel::kCodes; ++k) {
        if (k == 0 || k == 3 || k == 5) {
            EXPECT_NE(found.codes[at(k)], start[at(k)]);
            before = std::max(before, std::abs(slope(start, k)));
            after = std::max(after, std::abs(slope(found.codes, k)));
        } else {
            EXPECT_EQ(found.codes[at(k)], start[at(k)]);
            others = std::max(others, std::abs(slope(found.codes, k)));
        }
    }
    EXPECT_TRUE(after <= 3e-3 * before) << after << " of " << before;
    EXPECT_GT(others, 10 * after) << "the others would have helped";
    EXPECT_NEAR(found.rms * found.rms, mean_square(found.vertices, truth, subset.vertices), 1e-12);
}

TEST(FitSubset, EverythingListedInAnyOrderIsTheWholeFit) {
    const TriangleMesh mesh = bumpy_sphere(1);
    const WaveModel model(mesh, WaveModel::Kind::tanh);
    const VertexFit fit(model, mesh, EdgeWeights::cotangent);
    const std::vector<Point> truth = fit.positions(some_codes(1, 0.8));
    FitSubset all{{6, 5, 4, 3, 2, 1, 0}, every(1, mesh.vertex_count())};
    std::reverse(all.vertices.begin(), all.vertices.end());
    const std::vector<float> start = some_codes(4, 0.3);
    const FittedShape a = fit.fit(truth, start), b = fit.fit(truth, start, all);
    EXPECT_GT(a.steps, 0);
    EXPECT_EQ(a.codes, b.codes);
    EXPECT_EQ(a.vertices, b.vertices);
}

// Two spheres of which the second is unknown: it stays where it is beside the first.
TEST(FitSubset, PartsThatAreUnknownComeAlong) {
    const TriangleMesh mesh = two_spheres();
    const int half = mesh.vertex_count() / 2;
    const WaveModel model(mesh, WaveModel::Kind::tanh);
    const VertexFit fit = exact_fit(model, mesh, VertexSolver::poisson);
    const std::vector<float> wanted = some_codes(1, 0.5);
    const std::vector<Point> truth = moved(fit.positions(wanted), kMotion);
    const FitSubset subset{{0, 1}, every(2, half)};
    std::vector<float> start = wanted;
    start[0] += 0.1F;
    start[1] -= 0.1F;
    const FittedShape found = fit.fit(only(truth, subset.vertices), start, subset);
    EXPECT_GT(found.initial_rms, 1e-3);
    EXPECT_TRUE(found.rms <= 1e-6) << found.rms;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        ASSERT_TRUE((vec(found.vertices[i]) - vec(truth[i])).norm() <= 1e-4) << i;
    }
}

// Two spheres known in part: how they lie to each other comes from the codes, so that the unknown
// ends are found with the known ones, and a sphere that lies elsewhere stays an error.
TEST(FitSubset, PartsThatAreKnownInPartLieWhereTheCodesPutThem) {
    const TriangleMesh mesh = two_spheres();
    const int half = mesh.vertex_count() / 2;
    const WaveModel model(mesh, WaveModel::Kind::tanh);
    const VertexFit fit = exact_fit(model, mesh, VertexSolver::poisson);
    const std::vector<float> wanted = some_codes(1, 0.5);
    const std::vector<Point> truth = moved(fit.positions(wanted), kMotion);
    FitSubset subset;  // one end of each
    for (int v = 0; v < 2 * half; ++v) {
        if (mesh.vertices[at(v % half)][2] > 0.3) subset.vertices.push_back(v);
    }
    std::vector<float> start = wanted;
    for (std::size_t k = 0; k < start.size(); ++k) start[k] += some_codes(2, 0.2)[k];
    const FittedShape found = fit.fit(only(truth, subset.vertices), start, subset);
    EXPECT_GT(found.initial_rms, 1e-3);
    EXPECT_TRUE(found.rms <= 1e-6) << found.rms;
    EXPECT_LE(found.steps, 8);
    for (std::size_t i = 0; i < truth.size(); ++i) {
        ASSERT_TRUE((vec(found.vertices[i]) - vec(truth[i])).norm() <= 1e-4) << i;
    }
    std::vector<Point> apart = truth;
    for (int i = half; i < 2 * half; ++i) apart[at(i)][2] += 1.5;
    EXPECT_GT(fit.fit(only(apart, subset.vertices), start, subset).rms, 0.05);
}

TEST(FitSubset, RefusesWhatIsNotThere) {
    const TriangleMesh mesh = bumpy_sphere(1);
    const WaveModel model(mesh, WaveModel::Kind::tanh);
    const VertexFit fit(model, mesh, EdgeWeights::cotangent);
    const std::vector<float> start = some_codes(4, 0.3);
    const auto message = [&](const FitSubset& subset) {
        return thrown_message<UsageError>([&] { fit.fit(mesh.vertices, start, subset); });
    };
    EXPECT_EQ(message({{7}, {}}), "a fit of code 7, wanted 0 to 6");
    EXPECT_EQ(message({{-1, 3}, {}}), "a fit of code -1, wanted 0 to 6");
    EXPECT_EQ(message({{}, {1, 2, 42}}), "a fit of vertex 42, wanted 0 to 41");
    EXPECT_EQ(message({{}, {5, 2, 5}}), "a fit of vertex 5 twice, wanted it once");
}

}  // namespace
}  // namespace mscomp

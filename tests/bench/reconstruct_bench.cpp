// SPDX-License-Identifier: MIT
// What a further shape costs: the prefactorised solves of `reconstruct` against Ceres, which solves
// the same least-squares problem anew. Both run by turns on one thread; the vertices are compared
// before anything is timed. Counters: medians of the processor time, and their ratio.
#include <benchmark/benchmark.h>
#include <ceres/ceres.h>
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <memory>
#include <stdexcept>
#include <vector>

#include "acap/edge_weights.h"
#include "acap/rotation.h"
#include "mscomp/acap/extract.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/parallel.h"
#include "mscomp/generate/generate.h"
#include "mscomp/linear/blas_threads.h"

namespace mscomp {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Two poses of the arm besides its reference, and what is factorised once.
struct Arm {
    explicit Arm(int vertices) : set(features_of(generate_arm(3, 0, vertices))) {
        rings = one_rings_of_faces(set.reference.vertex_count(), set.reference.faces);
        weights = edge_weights(set.reference, rings, EdgeWeights::cotangent).weights;
        poisson = std::make_unique<PoissonReconstruction>(set.reference, EdgeWeights::cotangent);
        lossless = std::make_unique<LosslessReconstruction>(set.reference, EdgeWeights::cotangent);
    }
    static FeatureSet features_of(const GeneratedSequence& generated) {
        return extract_features(generated.sequence, generated.sequence.shapes[0]);
    }

    FeatureSet set;
    OneRings rings;
    std::vector<double> weights;
    std::unique_ptr<PoissonReconstruction> poisson;
    std::unique_ptr<LosslessReconstruction> lossless;
};

const Arm& arm_with(std::int64_t vertices) {
    static std::map<std::int64_t, std::unique_ptr<Arm>> all;
    auto& arm = all[vertices];
    if (!arm) arm = std::make_unique<Arm>(static_cast<int>(vertices));
    return *arm;
}

/// sqrt(c_ij) (p'_i - p'_j - ½ (T_i + T_j) (p_i - p_j)).
class EdgeResidual final : public ceres::SizedCostFunction<3, 3, 3> {
  public:
    EdgeResidual(double weight, const Vector3d& wanted)
        : root_(std::sqrt(weight)), wanted_(wanted) {}

    bool Evaluate(double const* const* points, double* residuals,
                  double** jacobians) const override {
        using Position = Eigen::Map<const Vector3d>;
        Eigen::Map<Vector3d> result(residuals);
        result = root_ * (Position(points[0]) - Position(points[1]) - wanted_);
        if (jacobians == nullptr) return true;
        for (int end = 0; end < 2; ++end) {
            if (jacobians[end] == nullptr) continue;
            Eigen::Map<Matrix3d> jacobian(jacobians[end]);
            jacobian = (end == 0 ? root_ : -root_) * Matrix3d::Identity();
        }
        return true;
    }

  private:
    double root_;
    Vector3d wanted_;
};

/// The Poisson equation as the linear least-squares problem whose normal equations it is, one block
/// per edge, analytic derivatives; vertex 0 stays.
std::vector<Point> poisson_by_ceres(const Arm& arm, std::span<const float> features) {
    const std::vector<Point>& reference = arm.set.reference.vertices;
    const std::vector<Matrix3d> gradients = gradients_of_features(features, reference.size());
    std::vector<Point> points = reference;
    ceres::Problem problem;
    for (Point& point : points) problem.AddParameterBlock(point.data(), 3);
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (int at = arm.rings.offsets[i]; at < arm.rings.offsets[i + 1]; ++at) {
            const auto j =
                static_cast<std::size_t>(arm.rings.neighbors[static_cast<std::size_t>(at)]);
            if (j < i) continue;
            const Vector3d edge = as_vector(reference[i]) - as_vector(reference[j]);
            problem.AddResidualBlock(new EdgeResidual(arm.weights[static_cast<std::size_t>(at)],
                                                      0.5 * ((gradients[i] + gradients[j]) * edge)),
                                     nullptr, points[i].data(), points[j].data());
        }
    }
    problem.SetParameterBlockConstant(points[0].data());
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.initial_trust_region_radius = 1e16;  // linear: the first full step is the solution
    options.max_num_iterations = 1;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return points;
}

/// Largest distance between the shapes, their centroids brought together, over the size of the
/// arm.
double difference(const std::vector<Point>& a, const std::vector<Point>& b) {
    Vector3d shift = Vector3d::Zero();
    for (std::size_t i = 0; i < a.size(); ++i) shift += as_vector(a[i]) - as_vector(b[i]);
    shift /= static_cast<double>(a.size());
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double off = (as_vector(a[i]) - as_vector(b[i]) - shift).norm();
        if (!(off <= largest)) largest = off;
    }
    return largest / 12;
}

void require_equal(const std::vector<Point>& a, const std::vector<Point>& b, double tolerance) {
    const double off = difference(a, b);
    if (!(off <= tolerance)) {
        throw std::runtime_error(fmt::format("vertices differ by {} of the size", off));
    }
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

/// Processor time of this thread, which other programs disturb less.
double now() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

template <class Body>
double milliseconds(int repeats, const Body& body) {
    const double start = now();
    for (int i = 0; i < repeats; ++i) benchmark::DoNotOptimize(body());
    return (now() - start) / repeats;
}

template <class Ours, class Ceres>
void by_turns(benchmark::State& state, const Ours& ours, const Ceres& by_ceres) {
    std::vector<double> fast, slow;
    for (auto _ : state) {
        slow.push_back(milliseconds(1, by_ceres));
        fast.push_back(milliseconds(20, ours));
    }
    state.counters["ceres_ms"] = median(slow);
    state.counters["ours_ms"] = median(fast);
    state.counters["ratio"] = median(slow) / median(fast);
}

void poisson(benchmark::State& state) {
    const Arm& arm = arm_with(state.range(0));
    const std::span<const float> features = arm.set.shape(2);
    require_equal(arm.poisson->solve(features), poisson_by_ceres(arm, features), 1e-9);
    by_turns(
        state, [&] { return arm.poisson->solve(features); },
        [&] { return poisson_by_ceres(arm, features); });
}

void lossless(benchmark::State& state) {
    const Arm& arm = arm_with(state.range(0));
    const std::span<const float> features = arm.set.shape(2);
    require_equal(arm.lossless->solve(features).vertices,
                  arm.lossless->solve_by_ceres(features).vertices, 1e-5);
    by_turns(
        state, [&] { return arm.lossless->solve(features).vertices; },
        [&] { return arm.lossless->solve_by_ceres(features).vertices; });
}

BENCHMARK(poisson)->Arg(12500)->Arg(50000)->Iterations(7)->Unit(benchmark::kMillisecond);
BENCHMARK(lossless)->Arg(12500)->Iterations(5)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mscomp

int main(int argc, char** argv) {
    mscomp::set_thread_count(1);
    mscomp::pin_blas_threads();
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
}

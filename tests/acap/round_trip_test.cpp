// SPDX-License-Identifier: MIT
// mesh -> features (float32) -> mesh on whole sets, real and generated.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>

#include "acap_cases.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/parallel.h"
#include "mscomp/generate/generate.h"

namespace mscomp {
namespace {

using namespace cases;

/// Pooled E_rms = 1000 |P - P'|_F / sqrt(3 N V) in the unit ball of the reference, each shape
/// aligned.
class Errors {
  public:
    explicit Errors(const std::vector<Point>& reference) {
        Vector3d center = Vector3d::Zero();
        for (const Point& p : reference) center += vec(p);
        center /= static_cast<double>(reference.size());
        for (const Point& p : reference) radius_ = std::max(radius_, (vec(p) - center).norm());
    }
    static double squares(const std::vector<Point>& truth, const std::vector<Point>& result) {
        const std::vector<Point> fitted = moved(result, best_rigid_motion(result, truth));
        double sum = 0;
        for (std::size_t i = 0; i < truth.size(); ++i) {
            sum += (vec(fitted[i]) - vec(truth[i])).squaredNorm();
        }
        return sum;
    }
    double value(const std::vector<double>& squares_of_shapes, std::size_t vertices) const {
        double sum = 0;
        for (const double x : squares_of_shapes) sum += x;
        const auto count = static_cast<double>(3 * vertices * squares_of_shapes.size());
        return 1000 * std::sqrt(sum / count) / radius_;
    }

  private:
    double radius_ = 0;
};

void expect_lossless(const MeshSequence& sequence, const char* name) {
    const FeatureSet set = extract_features(sequence, sequence.shapes.front());
    const PoissonReconstruction poisson(set.reference, EdgeWeights::cotangent);
    const LosslessReconstruction lossless(set.reference, EdgeWeights::cotangent);
    const Errors errors(set.reference.vertices);
    const auto count = static_cast<std::size_t>(set.shape_count());
    std::vector<double> by_poisson(count), by_lossless(count);
    std::vector<char> converged(count);
    parallel_for(set.shape_count(), [&](std::int64_t index) {
        const auto n = static_cast<std::size_t>(index);
        const std::vector<Point>& truth = sequence.shapes[n];
        const std::vector<Point> aligned =
            moved(truth, best_rigid_motion(truth, set.reference.vertices));
        const std::span<const float> features = set.shape(static_cast<int>(index));
        by_poisson[n] = Errors::squares(truth, poisson.solve(features, aligned));
        const ReconstructedShape result = lossless.solve(features, aligned);
        by_lossless[n] = Errors::squares(truth, result.vertices);
        converged[n] = result.converged ? 1 : 0;
    });
    const auto vertices = static_cast<std::size_t>(set.vertex_count());
    const double error = errors.value(by_lossless, vertices);
    std::printf("%s: E_rms %.3g, Poisson %.3g\n", name, error, errors.value(by_poisson, vertices));
    EXPECT_LE(error, 1e-3);
    EXPECT_LE(errors.value({*std::ranges::max_element(by_lossless)}, vertices), 1e-3);
    EXPECT_EQ(std::ranges::count(converged, 0), 0);
}

class RealRoundTrip : public testing::TestWithParam<const char*> {};

TEST_P(RealRoundTrip, LosesNothing) {
    const std::string folder = std::string(MSCOMP_SHARED_DIR "/data/") + GetParam();
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
    expect_lossless(read_sequence(expand_inputs({folder})), GetParam());
}

// The manifold sets, and two that are not: camel (edges of more than two faces), girl (pieces).
INSTANTIATE_TEST_SUITE_P(Sets, RealRoundTrip,
                         testing::Values("scape", "horse", "samba", "hand", "expressions", "camel",
                                         "girl"),
                         [](const auto& set) { return set.param; });

struct Generator {
    const char* name;
    std::function<GeneratedSequence()> make;
};

class GeneratedRoundTrip : public testing::TestWithParam<Generator> {};

TEST_P(GeneratedRoundTrip, LosesNothing) {
    expect_lossless(GetParam().make().sequence, GetParam().name);
}

INSTANTIATE_TEST_SUITE_P(
    Sets, GeneratedRoundTrip,
    testing::Values(Generator{"arm", [] { return generate_arm(30, 1, 2000); }},
                    Generator{"cloth", [] { return generate_cloth(30, 1, 2000); }},
                    Generator{"face", [] { return generate_face(30, 1, 2000); }},
                    Generator{"twist",
                              [] {
                                  return generate_twist(30, 1, 1000, {5, 0.5, 0, 0.05});
                              }}),
    [](const auto& set) { return set.param.name; });

}  // namespace
}  // namespace mscomp

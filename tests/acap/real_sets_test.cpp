// SPDX-License-Identifier: MIT
// Real poses, as a whole: extraction and the Poisson round trip.
#include <gtest/gtest.h>

#include <filesystem>

#include "acap_cases.h"
#include "mscomp/acap/alignment.h"
#include "mscomp/acap/reconstruct.h"

namespace mscomp {
namespace {

using namespace cases;

class RealSet : public testing::TestWithParam<const char*> {
  protected:
    void SetUp() override {
        const std::string folder = std::string(MSCOMP_SHARED_DIR "/data/") + GetParam();
        if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
        sequence_ = read_sequence(expand_inputs({folder}));
        set_ = extract_features(sequence_, sequence_.shapes.front());
    }

    /// 1000 |P - P'|_F / sqrt(3 N V) in the unit ball of the reference, each shape aligned.
    double round_trip_error() const {
        const PoissonReconstruction poisson(set_.reference, EdgeWeights::cotangent);
        Vector3d center = Vector3d::Zero();
        for (const Point& p : sequence_.shapes.front()) center += vec(p);
        center /= sequence_.vertex_count();
        double radius = 0, sum = 0;
        for (const Point& p : sequence_.shapes.front()) {
            radius = std::max(radius, (vec(p) - center).norm());
        }
        for (int n = 0; n < set_.shape_count(); ++n) {
            const std::vector<Point>& truth = sequence_.shapes[at(n)];
            const std::vector<Point> result = poisson.solve(set_.shape(n));
            const std::vector<Point> fitted = moved(result, best_rigid_motion(result, truth));
            for (std::size_t i = 0; i < truth.size(); ++i) {
                sum += (vec(fitted[i]) - vec(truth[i])).squaredNorm();
            }
        }
        return 1000 * std::sqrt(sum / (3.0 * set_.shape_count() * set_.vertex_count())) / radius;
    }

    MeshSequence sequence_;
    FeatureSet set_;
};

TEST_P(RealSet, FeaturesAreFiniteAndNoLessConsistentThanPrincipalLogarithms) {
    for (const float value : set_.features) ASSERT_TRUE(std::isfinite(value));
    const OneRings rings = one_rings_of_faces(set_.vertex_count(), set_.reference.faces);
    for (int n = 0; n < set_.shape_count(); ++n) {
        double principal = 0;
        const auto principal_log = [&](int i) {
            const Eigen::AngleAxisd turn(exp_of(rotation_vector(set_, i, n)));
            return Vector3d(turn.angle() * turn.axis());
        };
        for (int i = 0; i < set_.vertex_count(); ++i) {
            for (int k = rings.offsets[at(i)]; k < rings.offsets[at(i) + 1]; ++k) {
                const int j = rings.neighbors[at(k)];
                if (i < j) principal += (principal_log(i) - principal_log(j)).squaredNorm();
            }
        }
        EXPECT_LE(set_.consistency_energy[at(n)], principal * (1 + 1e-5) + 1e-9)
            << set_.names[at(n)];
        EXPECT_GE(set_.consistency_gap[at(n)], -1e-9 * principal);
    }
}

// The papers' reconstruction is approximate: 0.7 to 0.9 on human poses, about as much on the horse.
TEST_P(RealSet, PoissonRoundTripIsNear) {
    EXPECT_LE(round_trip_error(), GetParam() == std::string("scape") ? 0.9 : 1.0);
}

INSTANTIATE_TEST_SUITE_P(Sets, RealSet, testing::Values("scape", "horse"),
                         [](const auto& set) { return set.param; });

}  // namespace
}  // namespace mscomp

// SPDX-License-Identifier: MIT
// Joints that all move all the time, found where they turn.
#include "units/space_route.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mscomp/base/parallel.h"
#include "mscomp/base/points.h"
#include "multiscale/ball_cases.h"
#include "units/found_units.h"
#include "units/planted_units.h"
#include "units/turning_components.h"
#include "units/unit_components.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;

/// Five joints on a sphere, codes of the normal distribution, some noise.
struct Joints {
    explicit Joints(double noise = 0.001, int shapes = 50)
        : codes(cases::random_matrix(shapes, 5, 3)) {
        for (const auto& [i, j] : field.edges()) {
            const Point &p = sphere.mesh.vertices[at(i)], &q = sphere.mesh.vertices[at(j)];
            middles.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2});
        }
        const auto edges = std::ssize(middles);
        MatrixXd turns = MatrixXd::Zero(3 * edges, 5);
        for (int k = 0; k < 5; ++k) {
            const Point center = sphere.mesh.vertices[at(30 * k)];
            const Eigen::Vector3d axis = cases::random_matrix(3, 1, 20 + k).col(0).normalized();
            for (Eigen::Index e = 0; e < edges; ++e) {
                const double far =
                    std::sqrt(square_distance(middles[at(static_cast<int>(e))], center));
                const double near = std::max(0.0, 1 - far / 0.45);
                turns.block<3, 1>(3 * e, k) = 0.1 * near * axis;
            }
        }
        values = turns * codes.transpose() + noise * cases::random_matrix(turns.rows(), shapes, 9);
    }
    MetricRows rows() const { return cases::rows_of(values, 3); }
    static FoundUnits found_in(const MatrixXd& values, const std::vector<Point>& middles) {
        const MetricRows rows = cases::rows_of(values, 3);
        const MatrixXd gram = gram_of_shapes(rows);
        return find_turning_units(gram, edge_sample(rows, middles), gram);
    }

    cases::Sphere sphere;
    TurnField field{sphere.mesh};
    std::vector<Point> middles;
    MatrixXd codes, values;
};

TEST(SpaceRoute, FindsPlantedJointsAndHowToReadThem) {
    const Joints joints;
    const MetricRows rows = joints.rows();
    const MatrixXd gram = gram_of_shapes(rows);
    const TurningUnits found = space_route(gram, edge_sample(rows, joints.middles), 0.1);
    ASSERT_EQ(found.units.count(), 5);
    EXPECT_GT(cases::nearest_cosines(joints.codes, found.units.codes).minCoeff(), 0.99);
    EXPECT_LT((gram * found.readouts - found.units.codes).cwiseAbs().maxCoeff(), 1e-9);
    for (int k = 0; k < 5; ++k) {
        EXPECT_GE(found.units.votes[at(k)], 3);
        EXPECT_NEAR(found.units.codes.col(k).maxCoeff(), 1, 1e-12) << "the farthest code is 1";
    }
}

// A joint that bends a little otherwise where another one bends is seen twice, and is one; what
// moves alike elsewhere, or otherwise there, is another.
TEST(SpaceRoute, NoJointIsTakenTwice) {
    MatrixXd codes(200, 4);
    codes.leftCols(2) = cases::random_matrix(200, 2, 3);
    codes.col(2) = codes.col(0) + 0.3 * cases::random_matrix(200, 1, 8);  // correlate by 0.96
    codes.col(3) = codes.col(0) + 0.3 * cases::random_matrix(200, 1, 9);
    MatrixXd changes(3, 4);  // the third lies where the first does, the last does not
    changes << 1, 0, 0.9, 0, 0, 1, 0, 0, 0, 0, 0.435, 1;
    const double all = codes.squaredNorm();
    const auto sorted = [&] {
        std::vector<int> taken = needed_turns(codes, changes, all);
        std::ranges::sort(taken);
        return taken;
    };
    // The larger of both stands for both.
    codes.col(0) *= 1.2;
    EXPECT_EQ(sorted(), (std::vector<int>{0, 1, 3}));
    codes.col(2) *= 2;
    EXPECT_EQ(sorted(), (std::vector<int>{1, 2, 3}));
    // Of other codes, in the same place, it is a joint of its own.
    codes.col(2) = cases::random_matrix(200, 1, 10);
    EXPECT_EQ(sorted(), (std::vector<int>{0, 1, 2, 3}));
}

// What rests in no shape has no quiet read-out in codes, but one in space.
TEST(SpaceRoute, JointsAreFoundAgainWhereCodesAreNot) {
    const Joints joints;
    const FoundUnits turning = Joints::found_in(joints.values, joints.middles);
    ASSERT_EQ(turning.units.count(), 5);
    EXPECT_GE(turning.found_again(), 4);
    EXPECT_GT(turning.median_held_out(), 0.99);
    EXPECT_LT(turning.unexplained, 0.01);
    EXPECT_EQ(turning.noise, 0.1);
    const FoundUnits switching = find_switching_units(gram_of_shapes(joints.rows()));
    EXPECT_LT(switching.median_held_out(), 0.9);
    EXPECT_TRUE(are_turning(switching, turning));
}

TEST(SpaceRoute, NeitherTheOrderOfShapesNorTheUnitNorARigidMotionMatters) {
    const Joints joints;
    const FoundUnits wanted = Joints::found_in(joints.values, joints.middles);
    const std::vector<int> order = CounterRandom(5, 5).permutation(50);
    const MatrixXd mixed = 1000 * columns_of(joints.values, order);
    const FoundUnits found = Joints::found_in(mixed, joints.middles);
    ASSERT_EQ(found.units.count(), 5);
    MatrixXd again(50, 5);
    for (int n = 0; n < 50; ++n) again.row(order[at(n)]) = found.units.codes.row(n);
    EXPECT_GT(cases::nearest_cosines(wanted.units.codes, again).minCoeff(), 1 - 1e-9);
    // Turns along edges are told in the frames of vertices, which move along: only the places of
    // edges could matter.
    std::vector<Point> elsewhere;
    for (const Point& p : joints.middles)
        elsewhere.push_back({5 - 2 * p[1], 2 * p[0], 2 * p[2] + 7});
    const FoundUnits moved = Joints::found_in(joints.values, elsewhere);
    ASSERT_EQ(moved.units.count(), 5);
    EXPECT_GT(cases::nearest_cosines(wanted.units.codes, moved.units.codes).minCoeff(), 1 - 1e-6);
}

TEST(SpaceRoute, TheSameBitsForAnyNumberOfThreads) {
    const Joints joints;
    set_thread_count(1);
    const MatrixXd one = Joints::found_in(joints.values, joints.middles).units.codes;
    set_thread_count(3);
    const MatrixXd three = Joints::found_in(joints.values, joints.middles).units.codes;
    set_thread_count(0);
    EXPECT_EQ(one, three);
}

// Shapes and edges that do not move are no reason for anything to go wrong.
TEST(SpaceRoute, WhatDoesNotMoveIsLeftOut) {
    const Joints joints;
    EXPECT_EQ(
        Joints::found_in(MatrixXd::Zero(joints.values.rows(), 20), joints.middles).units.count(),
        0);
    MatrixXd resting = joints.values;
    resting.leftCols(20).setZero();
    resting.topRows(600).setZero();
    const FoundUnits found = Joints::found_in(resting, joints.middles);
    EXPECT_GE(found.units.count(), 3);
    EXPECT_TRUE(found.units.codes.allFinite());
    EXPECT_EQ(found.units.codes.topRows(20).cwiseAbs().maxCoeff(), 0);
}

TEST(SpaceRoute, JointsHaveToBeReadAndToExplain) {
    FoundUnits switching, turning;
    switching.held_out = {0.2, 0.3, 0.6};
    turning.held_out = {0.4, 0.6, 0.9};
    turning.unexplained = 0.2;
    EXPECT_TRUE(are_turning(switching, turning));
    EXPECT_FALSE(are_turning(turning, turning)) << "no better than codes";
    turning.unexplained = 0.4;
    EXPECT_FALSE(are_turning(switching, turning));
    turning.unexplained = 0.2;
    turning.held_out = {0.4, 0.45, 0.9};
    EXPECT_TRUE(are_turning(switching, turning)) << "little, but more than the others";
    turning.held_out = {0.1, 0.25, 0.9};
    EXPECT_FALSE(are_turning(switching, turning));
    EXPECT_FALSE(are_turning(switching, FoundUnits{}));
}

}  // namespace
}  // namespace mscomp

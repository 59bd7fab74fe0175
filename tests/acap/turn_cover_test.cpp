// SPDX-License-Identifier: MIT
#include "acap/turns/turn_cover.h"

#include <gtest/gtest.h>

#include "turn_cases.h"

namespace mscomp {
namespace {

using namespace cases;

/// Energy of the cover, written with vectors.
double cover_energy(const TurnProblem& problem, const TurnProblem::Turns& t,
                    const TurnProblem::Turns& opposite) {
    double sum = 0;
    for (const auto& [i, j] : problem.graph().edges) {
        const bool agree = problem.axis(i).dot(problem.axis(j)) >= 0;
        const auto cost = [&, a = i, b = j](int turn, int other) {
            const Vector3d r = problem.rotation_vector(a, turn);
            return (r - problem.rotation_vector(b, other)).squaredNorm();
        };
        sum += 0.5 * cost(t[at(i)], agree ? t[at(j)] : opposite[at(j)]);
        sum += 0.5 * cost(opposite[at(i)], agree ? opposite[at(j)] : t[at(j)]);
    }
    return sum;
}

double cover_energy(const TurnProblem& problem, const TurnCover& cover) {
    TurnProblem::Turns t, opposite;
    for (int i = 0; i < problem.vertex_count(); ++i) {
        t.push_back(cover.turn(i));
        opposite.push_back(cover.opposite_turn(i));
    }
    return cover_energy(problem, t, opposite);
}

class SmallCover : public testing::TestWithParam<std::uint64_t> {
  protected:
    SmallCover()
        : mesh_(all_connected(5)),
          graph_(graph_of(mesh_)),
          draws_(GetParam()),
          logs_(GetParam() % 2 == 0
                    ? half_turns(draws_, 5)
                    : random_logs(draws_, 5, 1 + 0.1 * static_cast<double>(GetParam()))),
          problem_(graph_, logs_) {}

    /// Turns of the copies in {-1, 0, 1} as a number in base 3, that of the root 0.
    void choice(int code, TurnProblem::Turns& t, TurnProblem::Turns& opposite) const {
        t.assign(5, 0);
        opposite.assign(5, 0);
        for (std::size_t i = 1; i < 5; ++i, code /= 9) {
            t[i] = code % 3 - 1;
            opposite[i] = code / 3 % 3 - 1;
        }
    }
    static constexpr int kChoices = 6561;  // 9^4

    TriangleMesh mesh_;
    ConsistencyGraph graph_;
    Draws draws_;
    Field logs_;
    TurnProblem problem_;
};

// With t = t' the cover has the energy of t.
TEST_P(SmallCover, EqualCopiesCostWhatTheTurnsCost) {
    TurnProblem::Turns t, opposite;
    for (int code = 0; code < kChoices; code += 17) {
        choice(code, t, opposite);
        EXPECT_NEAR(cover_energy(problem_, t, t), problem_.energy(t), 1e-10);
    }
}

// A move takes the best of all 2^8 sets of copies, and knows what it gains.
TEST_P(SmallCover, MovesTheBestOfAllSets) {
    TurnCover cover(problem_, TurnProblem::Turns(5, 0));
    const double start = cover_energy(problem_, cover);
    if (GetParam() % 2 == 0) cover.confine(2, 1, 3);  // t, t' and the limits are then not alike
    for (int round = 0; round < 6; ++round) {
        const int direction = round % 3 == 0 ? 1 : -1;
        const double before = cover_energy(problem_, cover);
        double least = before;
        for (int set = 0; set < 256; ++set) {
            TurnProblem::Turns t(5, 0), opposite(5, 0);
            bool allowed = true;
            for (int i = 1; i < 5; ++i) {
                const int bits = set >> (2 * (i - 1));
                t[at(i)] = cover.turn(i) + ((bits & 1) != 0 ? direction : 0);
                opposite[at(i)] = cover.opposite_turn(i) - ((bits & 2) != 0 ? direction : 0);
                for (const int turn : {t[at(i)], opposite[at(i)]}) {
                    allowed = allowed && turn >= cover.lower(i) && turn <= cover.upper(i);
                }
            }
            if (allowed) least = std::min(least, cover_energy(problem_, t, opposite));
        }
        EXPECT_EQ(cover.move_best_set(direction), least < before - 1e-8);
        EXPECT_NEAR(cover_energy(problem_, cover), least, 1e-8);
        EXPECT_NEAR(cover.change(), least - start, 1e-8);
    }
}

// L-natural convex: where no set helps, no choice does.
TEST_P(SmallCover, MinimumIsTheLeastOfAllChoices) {
    const TurnProblem::Turns zero(5, 0);
    TurnCover cover(problem_, zero);
    cover.minimize();
    const double start = cover_energy(problem_, zero, zero);
    double least = start, least_turns = start;
    TurnProblem::Turns t, opposite;
    for (int code = 0; code < kChoices; ++code) {
        choice(code, t, opposite);
        least = std::min(least, cover_energy(problem_, t, opposite));
        least_turns = std::min(least_turns, problem_.energy(t));
    }
    EXPECT_LE(start + cover.change(), least + 1e-9);
    EXPECT_LE(start + cover.change(), least_turns + 1e-9) << "not a bound";
    EXPECT_NEAR(cover_energy(problem_, cover), start + cover.change(), 1e-9);
}

TEST_P(SmallCover, ComesBackToAMark) {
    TurnCover cover(problem_, TurnProblem::Turns(5, 0));
    cover.minimize();
    const TurnCover::Mark mark = cover.mark();
    const double energy = cover_energy(problem_, cover), change = cover.change();
    const int upper = cover.upper(3);
    cover.confine(3, -4, cover.turn(3) - 1);
    cover.minimize();
    EXPECT_GE(cover.change(), change - 1e-9) << "fewer choices cannot be better";
    EXPECT_LT(std::max(cover.turn(3), cover.opposite_turn(3)), cover.upper(3) + 1);
    cover.return_to(mark);
    EXPECT_EQ(cover_energy(problem_, cover), energy);
    EXPECT_EQ(cover.change(), change);
    EXPECT_EQ(cover.upper(3), upper);
    EXPECT_FALSE(cover.move_best_set(1));
    EXPECT_FALSE(cover.move_best_set(-1));
}

INSTANTIATE_TEST_SUITE_P(Random, SmallCover, testing::Range<std::uint64_t>(0, 20));

// A minimum does not know where one came from, and every move gains what it says.
TEST(TurnCover, MinimumDoesNotDependOnTheStart) {
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
        const TriangleMesh mesh = seed % 2 == 0 ? shapes::grid(24, 24) : shapes::grid(200, 3);
        const ConsistencyGraph graph = graph_of(mesh);
        Draws draws(seed);
        Field smooth;
        for (const Point& p : mesh.vertices) {
            const Vector3d axis(1, 0.3 * std::sin(0.3 * p[0]), 0.2 * std::cos(0.2 * p[1]));
            smooth.push_back((0.4 * p[0] + 0.2 * p[1]) * axis + 0.4 * draws.vector());
        }
        const Field logs = principal(smooth);
        const TurnProblem problem(graph, logs);
        TurnProblem::Turns scattered(logs.size());
        for (int& turn : scattered) turn = static_cast<int>(2.5 * draws.next());
        scattered[0] = 0;
        double least = 0;
        for (const auto& start :
             {TurnProblem::Turns(logs.size(), 0), problem.propagated(), scattered}) {
            TurnCover cover(problem, start);
            const double before = cover_energy(problem, cover);
            double last = before;
            for (int still = 0; still < 2;) {
                still = cover.move_best_set(still == 0 ? 1 : -1) ? 0 : still + 1;
                const double now = cover_energy(problem, cover);
                ASSERT_NEAR(now, before + cover.change(), 1e-8 * before) << "seed " << seed;
                ASSERT_LE(now, last + 1e-9);
                last = now;
            }
            if (least == 0) least = last;
            EXPECT_NEAR(last, least, 1e-8 * before) << "seed " << seed;
        }
    }
}

// Only the relaxation can tear the copies apart, and here it does.
TEST(TurnCover, CopiesPartWhereAxesCannotAgree) {
    const TriangleMesh mesh = all_connected(8);
    const ConsistencyGraph graph = graph_of(mesh);
    int torn = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        Draws draws(seed);
        const Field logs = half_turns(draws, 8);
        const TurnProblem problem(graph, logs);
        TurnCover cover(problem, TurnProblem::Turns(8, 0));
        cover.minimize();
        for (int i = 0; i < 8; ++i) {
            if (cover.turn(i) == cover.opposite_turn(i)) continue;
            ++torn;
            break;
        }
    }
    EXPECT_GT(torn, 3);
}

}  // namespace
}  // namespace mscomp

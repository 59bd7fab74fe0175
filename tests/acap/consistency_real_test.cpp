// SPDX-License-Identifier: MIT
// The turns of real poses: proved least, and no large jump that could be had for less.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "acap/deformation_gradient.h"
#include "acap/polar.h"
#include "acap/turns/consistency.h"
#include "mscomp/acap/alignment.h"
#include "turn_cases.h"

namespace mscomp {
namespace {

using namespace cases;
constexpr double kPi = std::numbers::pi;

struct Logarithms {
    std::vector<Field> shapes;  // principal
    ConsistencyGraph graph;
};

Logarithms logarithms_of(const MeshSequence& sequence) {
    const TriangleMesh reference{sequence.shapes.front(), sequence.faces};
    const DeformationGradients gradients(reference, EdgeWeights::cotangent);
    Logarithms result;
    std::vector<double> unrest(reference.vertices.size(), 0.0);
    for (const std::vector<Point>& shape : sequence.shapes) {
        const RigidMotion motion = best_rigid_motion(shape, reference.vertices);
        Field logs;
        for (const Matrix3d& gradient : gradients.compute(moved(shape, motion)).gradients) {
            logs.push_back(rotation_log(polar_decomposition(gradient).rotation));
            unrest[logs.size() - 1] += logs.back().norm();
        }
        result.shapes.push_back(std::move(logs));
    }
    result.graph = consistency_graph(gradients.rings(), unrest);
    return result;
}

class RealTurns : public testing::TestWithParam<const char*> {
  protected:
    void SetUp() override {
        const std::string folder = std::string(MSCOMP_SHARED_DIR "/data/") + GetParam();
        if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
        logs_ = logarithms_of(read_sequence(expand_inputs({folder})));
    }

    double energy(const Field& r) const {
        double sum = 0;
        for (const auto& [i, j] : logs_.graph.edges) sum += (r[at(i)] - r[at(j)]).squaredNorm();
        return sum;
    }

    Logarithms logs_;
};

struct Table {
    double principal = 0, propagation = 0, result = 0, gap = 0, largest_jump = 0;
    int proved = 0, relaxed = 0, large = 0, inherent = 0, removable = 0;

    void add(const ConsistencySummary& summary) {
        principal += summary.principal_energy;
        propagation += summary.propagation_energy;
        result += summary.energy;
        gap += summary.energy - summary.lower_bound;
        largest_jump = std::max(largest_jump, summary.largest_jump);
        proved += summary.energy <= summary.lower_bound * (1 + 1e-9) + 1e-9 ? 1 : 0;
        relaxed += std::isnan(summary.relaxation_energy) ? 0 : 1;
        large += summary.large_jumps;
        inherent += summary.inherent_jumps;
        removable += summary.removable_jumps;
    }
    void print(const char* name, std::size_t shapes) const {
        std::printf("| %s | %zu | %.0f | %.0f | %.0f | %.3g | %d | %.2f | %d | %d | %d |\n", name,
                    shapes, principal, propagation, result, gap, proved, largest_jump, large,
                    inherent, removable);
    }
};

// Never above the cheap ways, proved least, and each large jump either cannot be had smaller by
// itself or costs energy elsewhere.
TEST_P(RealTurns, AreProvedLeastWithoutAJumpThatAMoveCouldRemove) {
    Table table;
    for (std::size_t n = 0; n < logs_.shapes.size(); ++n) {
        Field r = logs_.shapes[n];
        const ConsistencySummary summary = make_consistent(logs_.graph, r);
        table.add(summary);
        const double tolerance = 1e-9 * (1 + summary.principal_energy);
        // Rotations below 1e-4 count as if about the axis of their neighbours.
        EXPECT_NEAR(summary.energy, energy(r), 1e-5 * (1 + summary.energy)) << "shape " << n;
        EXPECT_NEAR(summary.principal_energy, energy(logs_.shapes[n]),
                    1e-5 * (1 + summary.principal_energy));
        EXPECT_LE(summary.energy, summary.principal_energy) << "shape " << n;
        EXPECT_LE(summary.energy, summary.propagation_energy) << "shape " << n;
        EXPECT_NEAR(summary.energy - summary.lower_bound, 0, tolerance) << "shape " << n;
        EXPECT_EQ(summary.removable_jumps, 0) << "shape " << n;
        int large = 0;
        double largest_jump = 0;
        for (const auto& [i, j] : logs_.graph.edges) {
            const double jump = (r[at(i)] - r[at(j)]).norm();
            largest_jump = std::max(largest_jump, jump);
            large += jump > kPi ? 1 : 0;
        }
        EXPECT_NEAR(summary.largest_jump, largest_jump, 1e-12);
        EXPECT_EQ(summary.large_jumps, large);
    }
    table.print(GetParam(), logs_.shapes.size());
}

// Tried one by one, away from the search.
TEST_P(RealTurns, NoVertexTurnedByOneLowersTheEnergy) {
    const OneRings& rings = logs_.graph.rings;
    for (std::size_t n = 0; n < logs_.shapes.size(); n += 3) {
        Field r = logs_.shapes[n];
        make_consistent(logs_.graph, r);
        const auto turned = [&](int vertex, double turns) -> Vector3d {
            const Vector3d& v = r[at(vertex)];
            return v.norm() > 1e-4 ? Vector3d(v + 2 * kPi * turns * v.normalized()) : v;
        };
        double least = 0;
        for (int i = 0; i < rings.vertex_count(); ++i) {
            const auto& roots = logs_.graph.roots;
            if (std::find(roots.begin(), roots.end(), i) != roots.end()) continue;
            for (const double turns : {-1.0, 1.0}) {
                const Vector3d here = turned(i, turns);
                double change = 0;
                for (int k = rings.offsets[at(i)]; k < rings.offsets[at(i) + 1]; ++k) {
                    const Vector3d& other = r[at(rings.neighbors[at(k)])];
                    change += (here - other).squaredNorm() - (r[at(i)] - other).squaredNorm();
                }
                least = std::min(least, change);
            }
        }
        EXPECT_GE(least, -1e-9) << "shape " << n;
    }
}

INSTANTIATE_TEST_SUITE_P(Sets, RealTurns,
                         testing::Values("scape", "horse", "samba", "hand", "expressions", "camel",
                                         "girl"),
                         [](const auto& set) { return set.param; });

}  // namespace
}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "minimum_cut.h"

#include <gtest/gtest.h>

#include <tuple>

#include "acap_cases.h"

namespace mscomp {
namespace {

using namespace cases;
using Edges = std::vector<std::tuple<int, int, double>>;

double cut_energy(const std::vector<double>& costs, const Edges& edges,
                  const std::vector<char>& ones) {
    double sum = 0;
    for (std::size_t i = 0; i < costs.size(); ++i) sum += ones[i] != 0 ? costs[i] : 0;
    for (const auto& [i, j, weight] : edges) sum += ones[at(i)] != ones[at(j)] ? weight : 0;
    return sum;
}

TEST(MinimumCut, FindsTheBestOfAllSubsets) {
    constexpr int kNodes = 9;
    int nontrivial = 0;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        Draws draws(seed);
        std::vector<double> costs(kNodes);
        for (double& cost : costs) cost = draws.next();
        Edges edges;
        for (int i = 0; i < kNodes; ++i) {
            for (int j = i + 1; j < kNodes; ++j) {
                if (draws.next() > 0) edges.emplace_back(i, j, 0.2 * (1 + draws.next()));
            }
        }
        MinimumCut cut(kNodes);
        for (int i = 0; i < kNodes; ++i) cut.add_cost(i, costs[at(i)]);
        for (const auto& [i, j, weight] : edges) cut.add_edge(i, j, weight);
        double least = 0;
        for (int subset = 0; subset < 1 << kNodes; ++subset) {
            std::vector<char> ones(kNodes);
            for (int i = 0; i < kNodes; ++i) ones[at(i)] = static_cast<char>(subset >> i & 1);
            least = std::min(least, cut_energy(costs, edges, ones));
        }
        const std::vector<char> found = cut.solve();
        EXPECT_NEAR(cut_energy(costs, edges, found), least, 1e-12);
        const auto size = std::count(found.begin(), found.end(), 1);
        if (size > 0 && size < kNodes) ++nontrivial;
    }
    EXPECT_GT(nontrivial, 10);
}

TEST(MinimumCut, TakesNothingThatDoesNotPay) {
    MinimumCut cut(3);
    cut.add_cost(0, 0.5);
    cut.add_edge(0, 1, 1);
    cut.add_edge(1, 2, 1);
    EXPECT_EQ(cut.solve(), (std::vector<char>{0, 0, 0}));
}

}  // namespace
}  // namespace mscomp

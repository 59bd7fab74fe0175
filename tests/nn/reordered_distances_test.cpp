// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <numeric>

#include "mscomp/base/random.h"
#include "nn/vertex_order.h"

namespace mscomp::nn {
namespace {

constexpr int kVertices = 50;
constexpr std::size_t kRowBytes = kVertices * sizeof(double);

double distance(int from, int to) { return 0.01 * from + 0.0001 * to * to; }

/// Keeps no more of its promise than it must: all rows turn to NaN at the next prepare().
class FleetingDistances final : public DistanceRows {
  public:
    int vertex_count() const override { return kVertices; }
    void prepare(std::span<const int> vertices) override {
        most_at_once = std::max(most_at_once, vertices.size());
        for (auto& [vertex, row] : rows_) {
            row.assign(row.size(), std::numeric_limits<double>::quiet_NaN());
        }
        gone_.push_back(std::move(rows_));
        rows_.clear();
        for (const int vertex : vertices) compute(vertex);
    }
    std::span<const double> row(int vertex) override { return compute(vertex); }

    std::size_t most_at_once = 0;
    int computed = 0;

  private:
    std::span<const double> compute(int vertex) {
        std::vector<double>& row = rows_[vertex];
        if (row.empty()) {
            ++computed;
            for (int i = 0; i < kVertices; ++i) row.push_back(distance(vertex, i));
        }
        return row;
    }

    std::map<int, std::vector<double>> rows_;
    std::vector<std::map<int, std::vector<double>>> gone_;
};

VertexOrder shuffled_order() {
    VertexOrder order;
    order.to_user = CounterRandom(5, 6).permutation(kVertices);
    order.to_internal.resize(kVertices);
    for (std::size_t i = 0; i < kVertices; ++i) {
        order.to_internal[static_cast<std::size_t>(order.to_user[i])] = static_cast<int>(i);
    }
    return order;
}

void expect_row(const VertexOrder& order, std::span<const double> row, int vertex) {
    ASSERT_EQ(row.size(), static_cast<std::size_t>(kVertices));
    const auto user = [&](int inner) { return order.to_user[static_cast<std::size_t>(inner)]; };
    for (int i = 0; i < kVertices; ++i) {
        ASSERT_EQ(row[static_cast<std::size_t>(i)], distance(user(vertex), user(i)));
    }
}

// d_inner(i, j) = d_user(user(i), user(j)), prepared or not, until the next prepare().
TEST(ReorderedDistances, HoldUntilTheNextPrepare) {
    const VertexOrder order = shuffled_order();
    for (const std::size_t limit : {ReorderedDistances::kCacheBytes, std::size_t{0}}) {
        FleetingDistances user;
        ReorderedDistances rows(user, order, limit);
        std::vector<int> all(kVertices - 1);
        std::iota(all.begin(), all.end(), 0);
        for (int round = 0; round < 3; ++round) {
            rows.prepare(all);
            std::vector<std::span<const double>> kept;
            for (int vertex = 0; vertex < kVertices; ++vertex) kept.push_back(rows.row(vertex));
            for (int vertex = 0; vertex < kVertices; ++vertex) {
                expect_row(order, kept[static_cast<std::size_t>(vertex)], vertex);
            }
        }
        EXPECT_LT(user.most_at_once, all.size()) << "not all of them twice at once";
    }
}

// Memory stays within the limit however many centres come and go, and kept rows come for nothing.
TEST(ReorderedDistances, KeepNoMoreThanTheLimit) {
    const VertexOrder order = shuffled_order();
    FleetingDistances user;
    ReorderedDistances rows(user, order, 10 * kRowBytes);
    for (int vertex = 0; vertex < kVertices; ++vertex) {
        rows.prepare(std::vector<int>{vertex, (vertex + 1) % kVertices});
        EXPECT_LE(rows.cached_bytes(), 10 * kRowBytes);
    }
    EXPECT_EQ(user.computed, kVertices + 1) << "only vertex 0 was forgotten when it came again";
    rows.prepare(std::vector<int>{kVertices - 5});
    EXPECT_EQ(user.computed, kVertices + 1);
}

}  // namespace
}  // namespace mscomp::nn

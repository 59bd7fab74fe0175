// SPDX-License-Identifier: MIT
#include "nn/vertex_order.h"

#include <algorithm>

#include "mscomp/base/index.h"

namespace mscomp::nn {
namespace {

/// Vertices reachable from `root` that are not yet `placed`, breadth first, neighbours by degree.
std::vector<int> breadth_first(const OneRings& rings, int root, std::vector<char>& placed) {
    std::vector<int> order{root};
    placed[at(root)] = 1;
    std::vector<int> fresh;
    for (std::size_t next = 0; next < order.size(); ++next) {
        const auto vertex = at(order[next]);
        fresh.clear();
        for (int place = rings.offsets[vertex]; place < rings.offsets[vertex + 1]; ++place) {
            const int neighbor = rings.neighbors[at(place)];
            if (placed[at(neighbor)] != 0) continue;
            placed[at(neighbor)] = 1;
            fresh.push_back(neighbor);
        }
        std::stable_sort(fresh.begin(), fresh.end(),
                         [&](int a, int b) { return rings.degree(a) < rings.degree(b); });
        order.insert(order.end(), fresh.begin(), fresh.end());
    }
    return order;
}

}  // namespace

VertexOrder reverse_cuthill_mckee(const OneRings& rings) {
    const auto count = at(rings.vertex_count());
    VertexOrder order;
    order.to_user.reserve(count);
    std::vector<char> placed(count, 0), probe(count, 0);
    for (std::size_t seed = 0; seed < count; ++seed) {
        if (placed[seed] != 0) continue;
        // The last vertex of a first sweep lies on the rim, which keeps the levels of the second
        // narrow.
        const int rim = breadth_first(rings, static_cast<int>(seed), probe).back();
        const std::vector<int> component = breadth_first(rings, rim, placed);
        order.to_user.insert(order.to_user.end(), component.begin(), component.end());
    }
    std::reverse(order.to_user.begin(), order.to_user.end());
    order.to_internal.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        order.to_internal[at(order.to_user[i])] = static_cast<int>(i);
    }
    return order;
}

OneRings reordered(const OneRings& rings, const VertexOrder& order) {
    OneRings result;
    result.neighbors.reserve(rings.neighbors.size());
    for (const int user : order.to_user) {
        const auto vertex = at(user);
        const auto first = static_cast<std::ptrdiff_t>(result.neighbors.size());
        for (int place = rings.offsets[vertex]; place < rings.offsets[vertex + 1]; ++place) {
            const int neighbor = rings.neighbors[at(place)];
            result.neighbors.push_back(order.to_internal[at(neighbor)]);
        }
        std::sort(result.neighbors.begin() + first, result.neighbors.end());
        result.offsets.push_back(static_cast<int>(result.neighbors.size()));
    }
    return result;
}

ReorderedDistances::ReorderedDistances(DistanceRows& user_rows, const VertexOrder& order,
                                       std::size_t cache_bytes)
    : user_rows_(user_rows), order_(order), cache_(cache_bytes) {}

void ReorderedDistances::prepare(std::span<const int> vertices) {
    cache_.start_round();
    std::vector<int> fresh;
    for (const int vertex : vertices) {
        if (!cache_.find(vertex)) fresh.push_back(vertex);
    }
    std::sort(fresh.begin(), fresh.end());
    fresh.erase(std::unique(fresh.begin(), fresh.end()), fresh.end());
    // Some at a time, so that not all are there twice at once.
    constexpr std::size_t kRowsAtOnce = 32;
    std::vector<int> user;
    for (std::size_t begin = 0; begin < fresh.size(); begin += kRowsAtOnce) {
        const std::size_t end = std::min(begin + kRowsAtOnce, fresh.size());
        user.clear();
        for (std::size_t k = begin; k < end; ++k) {
            user.push_back(order_.to_user[at(fresh[k])]);
        }
        user_rows_.prepare(user);
        for (std::size_t k = begin; k < end; ++k) {
            cache_.put(fresh[k], copy_of(user_rows_.row(user[k - begin])));
        }
    }
}

std::span<const double> ReorderedDistances::row(int vertex) {
    if (const auto known = cache_.find(vertex)) return *known;
    return cache_.put(vertex, copy_of(user_rows_.row(order_.to_user[at(vertex)])));
}

std::vector<double> ReorderedDistances::copy_of(std::span<const double> user_row) const {
    std::vector<double> copy;
    copy.reserve(user_row.size());
    for (const int place : order_.to_user) copy.push_back(user_row[at(place)]);
    return copy;
}

}  // namespace mscomp::nn

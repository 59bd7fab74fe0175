// SPDX-License-Identifier: MIT
#include "mscomp/geodesic/heat_geodesics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "heat_divergence.h"
#include "heat_matrices.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"
#include "mscomp/geodesic/intrinsic_triangles.h"
#include "mscomp/linear/block_cholesky.h"

namespace mscomp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Heat put into the source: far up in the range of double, so that it can fade for longer.
constexpr double kSourceHeat = 1e200;
/// Heat fades by a factor e over sqrt(t). It may do so this many times: from kSourceHeat it takes
/// 1,170 to the end of the normal numbers.
constexpr double kMostFading = 1000;

constexpr std::size_t kRowsPerSolve = 8;

/// (C) t by component: `time`, or what lets heat reach its farthest vertex.
std::vector<double> times(const IntrinsicTriangles& surface, std::span<const IntrinsicEdge> edges,
                          double time) {
    std::vector<double> result = component_extents(surface, edges);
    for (double& extent : result) {
        const double least = extent / kMostFading;
        extent = std::max(time, least * least);
    }
    return result;
}

std::vector<bool> without_triangle(const IntrinsicTriangles& surface) {
    std::vector<bool> lonely(at(surface.vertex_count), true);
    for (const FlatTriangle& triangle : surface.triangles) {
        for (const int vertex : triangle.corners) lonely[at(vertex)] = false;
    }
    return lonely;
}

/// L determines phi up to one constant per component: phi is held at 0 at each component's lowest
/// vertex. Distances are differences, so the choice does not show in them.
std::vector<bool> anchors(const IntrinsicTriangles& surface, std::vector<bool> lonely) {
    int next = 0;
    for (std::size_t i = 0; i < lonely.size(); ++i) {
        if (surface.component[i] != next) continue;
        lonely[i] = true;
        ++next;
    }
    return lonely;
}

}  // namespace

struct HeatGeodesics::State {
    State(IntrinsicTriangles&& triangles, double time)
        : State(std::move(triangles), time, intrinsic_edges(triangles)) {}

    /// Rows of up to kLanes source sets.
    template <std::size_t kLanes>
    void solve(std::span<const std::vector<int>> source_sets,
               std::span<std::vector<double>> rows) const;
    /// Distances from `sources` given phi, every `lanes`-th number.
    std::vector<double> shifted(const double* phi, std::size_t lanes,
                                std::span<const int> sources) const;

    IntrinsicTriangles surface;
    std::vector<bool> anchored;  // where phi is held at 0
    BlockCholesky heat;
    BlockCholesky poisson;

  private:
    State(IntrinsicTriangles&& triangles, double time, std::span<const IntrinsicEdge> edges)
        : surface(std::move(triangles)),
          anchored(anchors(surface, without_triangle(surface))),
          heat(heat_matrix(surface, edges, times(surface, edges, time), without_triangle(surface)),
               "the heat matrix of the geodesics"),
          poisson(poisson_matrix(edges, anchored), "the Poisson matrix of the geodesics", heat) {}
};

template <std::size_t kLanes>
void HeatGeodesics::State::solve(std::span<const std::vector<int>> source_sets,
                                 std::span<std::vector<double>> rows) const {
    const auto size = at(surface.vertex_count);
    if (size == 0) return;
    std::vector<Lanes<kLanes>> u(size, Lanes<kLanes>{}), phi(size, Lanes<kLanes>{}), work;
    for (std::size_t lane = 0; lane < source_sets.size(); ++lane) {
        for (const int source : source_sets[lane]) {
            u[at(source)][lane] = kSourceHeat;
        }
    }
    heat.solve(u, work);
    add_divergence(surface.triangles, u.front().data(), phi.front().data(), kLanes);
    for (std::size_t i = 0; i < size; ++i) {
        if (anchored[i]) phi[i] = Lanes<kLanes>{};
    }
    poisson.solve(phi, work);
    for (std::size_t lane = 0; lane < source_sets.size(); ++lane) {
        rows[lane] = shifted(phi.front().data() + lane, kLanes, source_sets[lane]);
    }
}

std::vector<double> HeatGeodesics::State::shifted(const double* phi, std::size_t lanes,
                                                  std::span<const int> sources) const {
    const auto size = at(surface.vertex_count);
    std::vector<int> source_of(size + 1, -1);  // by component
    for (const int source : sources) {
        source_of[at(surface.component[at(source)])] = source;
    }
    std::vector<double> row(size, kInfinity);
    for (std::size_t i = 0; i < size; ++i) {
        const int source = source_of[at(surface.component[i])];
        if (source < 0) continue;
        const double difference = phi[i * lanes] - phi[at(source) * lanes];
        row[i] = std::max(difference * surface.mean_edge_length, 0.0);
    }
    return row;
}

HeatGeodesics::HeatGeodesics(const TriangleMesh& mesh, double time_factor) {
    if (!(time_factor > 0) || !std::isfinite(time_factor)) {
        throw UsageError(
            fmt::format("geodesics: the time factor is {}, wanted a positive number", time_factor));
    }
    // Lengths are in mean edge lengths already, so t is the factor itself.
    state_ = std::make_unique<State>(intrinsic_triangles(mesh), time_factor);
}
HeatGeodesics::HeatGeodesics(HeatGeodesics&&) noexcept = default;
HeatGeodesics& HeatGeodesics::operator=(HeatGeodesics&&) noexcept = default;
HeatGeodesics::~HeatGeodesics() = default;

int HeatGeodesics::vertex_count() const { return state_->surface.vertex_count; }

std::span<const int> HeatGeodesics::components() const { return state_->surface.component; }

std::vector<double> HeatGeodesics::distances(int source) const {
    return std::move(distance_rows(std::span<const int>(&source, 1)).front());
}

std::vector<std::vector<double>> HeatGeodesics::distance_rows(std::span<const int> sources) const {
    std::vector<std::vector<int>> sets;
    sets.reserve(sources.size());
    for (const int source : sources) sets.push_back({source});
    return distance_rows(sets);
}

std::vector<std::vector<double>> HeatGeodesics::distance_rows(
    std::span<const std::vector<int>> source_sets) const {
    for (const std::vector<int>& sources : source_sets) {
        for (const int source : sources) {
            assert(source >= 0 && source < vertex_count());
            static_cast<void>(source);
        }
    }
    std::vector<std::vector<double>> rows(source_sets.size());
    const Chunks chunks{static_cast<std::int64_t>(source_sets.size()),
                        static_cast<std::int64_t>(kRowsPerSolve)};
    parallel_for(chunks.count(), [&](std::int64_t chunk) {
        const auto begin = at(chunks.begin(chunk));
        const auto count = at(chunks.end(chunk)) - begin;
        const auto sets = source_sets.subspan(begin, count);
        const auto results = std::span(rows).subspan(begin, count);
        if (count == 1) {
            state_->solve<1>(sets, results);
        } else if (count <= 4) {
            state_->solve<4>(sets, results);
        } else {
            state_->solve<8>(sets, results);
        }
    });
    return rows;
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/geodesic/heat_geodesics.h"

#include <fmt/format.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"
#include "mscomp/geodesic/intrinsic_triangles.h"
#include "mscomp/linear/block_cholesky.h"

namespace mscomp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Heat put into the source: far up in the range of double, so that it can fade for longer.
constexpr double kSourceHeat = 1e200;
/// Cotangent weights are raised to this in the heat step: with a negative one heat may change sign,
/// and then distances are wrong by half. The energy of the Poisson step is a sum of energies >= 0
/// whatever the signs and needs no such thing.
constexpr double kSmallestHeatWeight = 1e-3;

using SparseMatrix = Eigen::SparseMatrix<double>;

constexpr std::size_t kLanes = 8;  // rows solved together
using Lanes = BlockCholesky<kLanes>::Lanes;

/// One undirected edge and its cotangent weight.
struct Edge {
    int i = 0, j = 0;
    double weight = 0;
};

std::vector<Edge> cotangent_edges(const IntrinsicTriangles& surface) {
    std::vector<Edge> edges;
    edges.reserve(surface.triangles.size() * 3);
    for (const FlatTriangle& triangle : surface.triangles) {
        const std::array<double, 3> cotangents = triangle.cotangents();
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [i, j] =
                std::minmax(triangle.corners[(k + 1) % 3], triangle.corners[(k + 2) % 3]);
            edges.push_back({i, j, 0.5 * cotangents[k]});
        }
    }
    std::stable_sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
        return a.i != b.i ? a.i < b.i : a.j < b.j;
    });
    std::size_t count = 0;
    for (const Edge& edge : edges) {
        if (count > 0 && edges[count - 1].i == edge.i && edges[count - 1].j == edge.j) {
            edges[count - 1].weight += edge.weight;
        } else {
            edges[count++] = edge;
        }
    }
    edges.resize(count);
    return edges;
}

/// diagonal + sum of the edges' weights; rows with `fixed` set become those of the identity.
SparseMatrix assemble(const std::vector<double>& diagonal, const std::vector<Edge>& edges,
                      const std::vector<bool>& fixed) {
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(edges.size() * 4 + fixed.size());
    const auto add = [&](int i, int j, double value) {
        if (fixed[static_cast<std::size_t>(i)] || fixed[static_cast<std::size_t>(j)]) return;
        entries.emplace_back(i, j, value);
    };
    for (const Edge& edge : edges) {
        add(edge.i, edge.i, edge.weight);
        add(edge.j, edge.j, edge.weight);
        add(edge.i, edge.j, -edge.weight);
        add(edge.j, edge.i, -edge.weight);
    }
    for (std::size_t i = 0; i < fixed.size(); ++i) {
        const int row = static_cast<int>(i);
        entries.emplace_back(row, row, fixed[i] ? 1.0 : diagonal[i]);
    }
    const auto size = static_cast<Eigen::Index>(fixed.size());
    SparseMatrix matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

SparseMatrix heat_matrix(const IntrinsicTriangles& surface, double time,
                         const std::vector<bool>& lonely) {
    std::vector<Edge> edges = cotangent_edges(surface);
    for (Edge& edge : edges) edge.weight = time * std::max(edge.weight, kSmallestHeatWeight);
    return assemble(lumped_mass(surface), edges, lonely);
}

SparseMatrix poisson_matrix(const IntrinsicTriangles& surface, const std::vector<bool>& anchored) {
    return assemble(std::vector<double>(anchored.size(), 0.0), cotangent_edges(surface), anchored);
}

std::vector<bool> without_triangle(const IntrinsicTriangles& surface) {
    std::vector<bool> lonely(static_cast<std::size_t>(surface.vertex_count), true);
    for (const FlatTriangle& triangle : surface.triangles) {
        for (const int vertex : triangle.corners) lonely[static_cast<std::size_t>(vertex)] = false;
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

/// Per face and lane the integrated divergence of the unit field against the gradient of `heat`.
void add_divergence(const FlatTriangle& triangle, const std::vector<Lanes>& heat,
                    std::vector<Lanes>& divergence) {
    const auto p = static_cast<std::size_t>(triangle.corners[0]);
    const auto q = static_cast<std::size_t>(triangle.corners[1]);
    const auto r = static_cast<std::size_t>(triangle.corners[2]);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const double along = (heat[q][lane] - heat[p][lane]) / triangle.base;
        const double across = (heat[r][lane] - heat[p][lane] - triangle.x * along) / triangle.y;
        // Dividing by the larger part first keeps the squares inside the range of double.
        const double larger = std::max(std::abs(along), std::abs(across));
        const double scale = larger > 0 ? 1 / larger : 0.0;
        const double gx = std::isfinite(scale) ? along * scale : 0.0;
        const double gy = std::isfinite(scale) ? across * scale : 0.0;
        const double norm = std::sqrt(gx * gx + gy * gy);
        const double ux = norm > 0 ? -gx / norm : 0.0;
        const double uy = norm > 0 ? -gy / norm : 0.0;
        const double at_q = 0.5 * (triangle.y * ux - triangle.x * uy);
        const double at_r = 0.5 * triangle.base * uy;
        divergence[p][lane] -= at_q + at_r;
        divergence[q][lane] += at_q;
        divergence[r][lane] += at_r;
    }
}

}  // namespace

struct HeatGeodesics::State {
    State(IntrinsicTriangles triangles, double time)
        : surface(std::move(triangles)),
          lonely(without_triangle(surface)),
          anchored(anchors(surface, lonely)),
          heat(heat_matrix(surface, time, lonely), "the heat matrix of the geodesics"),
          poisson(poisson_matrix(surface, anchored), "the Poisson matrix of the geodesics") {}

    /// Rows of up to kLanes source sets.
    void solve(std::span<const std::vector<int>> source_sets,
               std::span<std::vector<double>> rows) const;
    std::vector<double> shifted(const std::vector<Lanes>& phi, std::size_t lane,
                                std::span<const int> sources) const;

    IntrinsicTriangles surface;
    std::vector<bool> lonely;    // in no triangle
    std::vector<bool> anchored;  // where phi is held at 0
    BlockCholesky<kLanes> heat;
    BlockCholesky<kLanes> poisson;
};

void HeatGeodesics::State::solve(std::span<const std::vector<int>> source_sets,
                                 std::span<std::vector<double>> rows) const {
    const auto size = static_cast<std::size_t>(surface.vertex_count);
    std::vector<Lanes> u(size, Lanes{}), work;
    for (std::size_t lane = 0; lane < source_sets.size(); ++lane) {
        for (const int source : source_sets[lane]) {
            u[static_cast<std::size_t>(source)][lane] = kSourceHeat;
        }
    }
    heat.solve(u, work);
    std::vector<Lanes> phi(size, Lanes{});
    for (const FlatTriangle& triangle : surface.triangles) add_divergence(triangle, u, phi);
    for (std::size_t i = 0; i < size; ++i) {
        if (anchored[i]) phi[i] = Lanes{};
    }
    poisson.solve(phi, work);
    for (std::size_t lane = 0; lane < source_sets.size(); ++lane) {
        rows[lane] = shifted(phi, lane, source_sets[lane]);
    }
}

std::vector<double> HeatGeodesics::State::shifted(const std::vector<Lanes>& phi, std::size_t lane,
                                                  std::span<const int> sources) const {
    std::vector<int> source_of(phi.size() + 1, -1);  // by component
    for (const int source : sources) {
        source_of[static_cast<std::size_t>(surface.component[static_cast<std::size_t>(source)])] =
            source;
    }
    std::vector<double> row(phi.size(), kInfinity);
    for (std::size_t i = 0; i < row.size(); ++i) {
        const int source = source_of[static_cast<std::size_t>(surface.component[i])];
        if (source < 0) continue;
        const double difference = phi[i][lane] - phi[static_cast<std::size_t>(source)][lane];
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
                        static_cast<std::int64_t>(kLanes)};
    parallel_for(chunks.count(), [&](std::int64_t chunk) {
        const auto begin = static_cast<std::size_t>(chunks.begin(chunk));
        const auto count = static_cast<std::size_t>(chunks.end(chunk)) - begin;
        state_->solve(source_sets.subspan(begin, count), std::span(rows).subspan(begin, count));
    });
    return rows;
}

}  // namespace mscomp

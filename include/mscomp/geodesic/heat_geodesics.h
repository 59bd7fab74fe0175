// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/base/row_cache.h"

namespace mscomp {

/// Geodesic distances by the heat method (Crane, Weischedel, Wardetzky 2013), both factorisations
/// kept, in the unit of the mesh:
///   (M + t L) u = delta_source,   X = -grad u / |grad u| per face,   L phi = div X,
/// with the cotangent Laplacian L and the lumped mass M of IntrinsicTriangles and
/// t = time_factor * (mean edge length)^2. Heat fades by a factor e over sqrt(t); where a component
/// is more than 1,000 times as long as that, its t is (longest path along edges / 1000)^2, so that
/// heat reaches every vertex. The triangles are flipped to be intrinsically Delaunay
/// first; weights that are negative nevertheless (non-manifold edges) are raised to 1e-3 in the
/// first equation only. Distances are phi - phi(source), clamped to >= 0; they are infinite in
/// another connected component. Works on any connectivity, non-manifold included, and on zero-area
/// faces and isolated vertices. Scaling the mesh scales the distances.
class HeatGeodesics {
  public:
    /// Throws MeshError (coordinate not finite, face index out of range), UsageError (time_factor
    /// not positive) or NumericalError (factorisation failed).
    explicit HeatGeodesics(const TriangleMesh& mesh, double time_factor = 1.0);
    HeatGeodesics(HeatGeodesics&&) noexcept;
    HeatGeodesics& operator=(HeatGeodesics&&) noexcept;
    ~HeatGeodesics();

    int vertex_count() const;
    /// (V) connected component of every vertex, numbered in the order of their lowest vertex.
    std::span<const int> components() const;

    /// (V) distances from `source`. Deterministic; safe to call from several threads.
    std::vector<double> distances(int source) const;
    /// One row (V) for each of `sources`, computed in parallel; equal to distances() bit for bit.
    std::vector<std::vector<double>> distance_rows(std::span<const int> sources) const;
    /// For each of `source_sets` one row (V): every vertex's distance from the source in its own
    /// component, infinity if there is none. A set has at most one vertex of each component.
    std::vector<std::vector<double>> distance_rows(
        std::span<const std::vector<int>> source_sets) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The largest pairwise distance within a component: exact (all rows) up to `exact_limit` vertices,
/// beyond that a lower bound from repeated farthest-point sweeps (in each component: from the
/// lowest vertex to the farthest, on from there until nothing grows, then from the vertices
/// farthest from all sources so far).
struct GeodesicNormalizer {
    double largest_distance = 0;
    bool exact = false;
};
GeodesicNormalizer geodesic_normalizer(const HeatGeodesics& geodesics, int exact_limit = 5000);

/// Rows of distance / normalizer, clamped to [0, 1] (other components: 1). Computed rows are kept
/// up to a limit in bytes beyond those that were prepared last or asked for since: what was used
/// longest ago goes first. Not for use from several threads at once.
class NormalizedGeodesics final : public DistanceRows {
  public:
    static constexpr std::size_t kCacheBytes = std::size_t{1} << 29;

    /// Throws NumericalError if `largest_distance` is negative or not finite.
    NormalizedGeodesics(HeatGeodesics geodesics, double largest_distance,
                        std::size_t cache_bytes = kCacheBytes);
    int vertex_count() const override { return geodesics_.vertex_count(); }
    std::span<const double> row(int vertex) override;
    /// Computes those of `vertices` that are not there yet, in parallel, eight at a time.
    void prepare(std::span<const int> vertices) override;
    int cached_rows() const { return static_cast<int>(cache_.row_count()); }
    std::size_t cached_bytes() const { return cache_.bytes(); }

  private:
    std::span<const double> store(int vertex, std::vector<double> distances);

    HeatGeodesics geodesics_;
    double largest_distance_;
    RowCache cache_;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Geodesic distances by the heat method (Crane, Weischedel, Wardetzky 2013), both factorisations
/// kept, in the unit of the mesh. t = time_factor * (mean edge length)^2. Distances are >= 0, 0 at
/// the source, infinity in another connected component. Works on any connectivity, non-manifold
/// included.
class HeatGeodesics {
  public:
    explicit HeatGeodesics(const TriangleMesh& mesh, double time_factor = 1.0);
    HeatGeodesics(HeatGeodesics&&) noexcept;
    HeatGeodesics& operator=(HeatGeodesics&&) noexcept;
    ~HeatGeodesics();

    int vertex_count() const;
    /// (V) distances from `source`. Deterministic; safe to call from several threads.
    std::vector<double> distances(int source) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The largest pairwise distance within a component: exact (all rows) up to `exact_limit` vertices,
/// beyond that a lower bound from repeated farthest-point sweeps.
struct GeodesicNormalizer {
    double largest_distance = 0;
    bool exact = false;
};
GeodesicNormalizer geodesic_normalizer(const HeatGeodesics& geodesics, int exact_limit = 5000);

/// Rows of distance / normalizer, clamped to [0, 1] (other components: 1), computed on first use
/// and cached.
class NormalizedGeodesics final : public DistanceRows {
  public:
    NormalizedGeodesics(HeatGeodesics geodesics, double largest_distance);
    std::span<const double> row(int vertex) override;
    int cached_rows() const;

  private:
    HeatGeodesics geodesics_;
    double largest_distance_;
    std::vector<std::vector<double>> rows_;  // (V), empty until asked for
};

}  // namespace mscomp

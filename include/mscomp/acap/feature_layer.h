// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>

#include "mscomp/acap/edge_weights.h"
#include "mscomp/base/mesh_data.h"

namespace mscomp {

/// Which linear equations say how positions follow from deformation gradients.
enum class LayerEquations {
    /// Those of PoissonReconstruction: positions() is its solve(). The smaller factor.
    poisson,
    /// Those of the start of LosslessReconstruction, six for each vertex: features of a mesh give
    /// that mesh, but for a share of the Laplacian of 1e-6. The factor is 3 to 4 times larger.
    tangential
};

/// Positions of many shapes from their features by one linear solve each, and the exact adjoint of
/// its derivative, for training by an error of positions: p(T) = p_ref + A⁻¹ Σ_v (T_v - 1) q_v with
/// T = exp(r) S. Connected components are joined as by Pieces::joined; the centroid of each shape
/// is 0. The features of the reference give the reference itself.
///
/// Shapes are solved eight at a time, and every shape's result is the same bit for bit for any
/// number of threads and whatever other shapes come with it. Both calls are safe from several
/// threads; memory that they need is kept for the next.
class FeatureLayer {
  public:
    /// Factorises. Throws MeshError and NumericalError as the reconstructions do.
    FeatureLayer(const TriangleMesh& reference, EdgeWeights weights, LayerEquations equations);
    FeatureLayer(FeatureLayer&&) noexcept;
    FeatureLayer& operator=(FeatureLayer&&) noexcept;
    ~FeatureLayer();

    int vertex_count() const;

    /// `features` (n,V,9) unscaled -> `positions` (n,V,3), overwritten, in the unit of the
    /// reference. Throws MeshError where sizes do not fit, NumericalError on features that are not
    /// finite.
    void positions(std::span<const double> features, std::span<double> positions) const;

    /// dE/dp (n,V,3) of positions() at `features` (n,V,9) -> dE/d(r, S) (n,V,9), overwritten; a
    /// channel beside the diagonal of S stands for two entries of it. dE/dT_v = Σ_j (λ_j - λ_v)
    /// q_vjᵀ, λ = A⁻¹ dE/dp. Errors as positions().
    void adjoint(std::span<const double> features, std::span<const double> by_position,
                 std::span<double> by_feature) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mscomp

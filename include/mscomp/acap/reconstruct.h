// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mscomp/acap/edge_weights.h"
#include "mscomp/base/feature_set.h"

namespace mscomp {

/// Positions found for features.
struct ReconstructedShape {
    std::vector<Point> vertices;  // (V) in the unit of the reference
    /// How far the features are from being those of a mesh: the least-squares residual of the six
    /// equations of each vertex that leave the pseudo-edge out, relative to the features. About
    /// 3e-8 (float32) for features of a mesh. With handles, that of the result.
    double residual = 0;
    double energy = 0;       // E of the result, relative to its value for a shape without size
    int steps = 0;           // descent steps from the linear start
    bool converged = false;  // the last step changed next to nothing
};

/// Features do not say where connected components lie. What is done about it:
enum class Pieces {
    /// Every component gets the centroid that it has in another shape.
    as_in_shape,
    /// Components lie to each other as the features let expect: what links each vertex of the
    /// smaller to the nearest of the larger one in the reference turns and stretches with the
    /// surface at its ends, on average. The whole gets the centroid of the other shape.
    joined
};

/// A vertex that is wanted at `position`: exactly if `weight` is infinite, otherwise by adding
/// weight |p' - position|² to the energy (whose own weights c_ij are of the order of 1).
struct Handle {
    int vertex = -1;
    Point position{};
    double weight = std::numeric_limits<double>::infinity();
};

/// A direction in feature space: zero at all vertices but these. Borrows both.
struct FeatureDirection {
    std::span<const int> vertices;
    std::span<const float> values;  // (vertices,9)
};

/// Positions from features by the Poisson equation of method §2 (the papers' layer F): the
/// Laplacian of the reference, anchored once per connected component and factorised once, three
/// right-hand sides a shape. Approximate: the features of a mesh give back that mesh only nearly.
class PoissonReconstruction {
  public:
    PoissonReconstruction(const TriangleMesh& reference, EdgeWeights weights);
    PoissonReconstruction(PoissonReconstruction&&) noexcept;
    PoissonReconstruction& operator=(PoissonReconstruction&&) noexcept;
    ~PoissonReconstruction();

    /// `features` (V,9) unscaled -> (V) positions. Where they lie is that of `like` (V) by
    /// `pieces`; without it they are joined, with the centroid of the reference. Throws
    /// NumericalError on non-finite features, MeshError for another V. Safe to call from several
    /// threads.
    std::vector<Point> solve(std::span<const float> features, std::span<const Point> like = {},
                             Pieces pieces = Pieces::as_in_shape) const;
    /// Overwrites `result` (directions,V,3) with the derivatives of solve(), the components joined,
    /// at `features` along `directions`. The same bits for any number of threads. Errors and
    /// threads as solve().
    void derivatives(std::span<const float> features, std::span<const FeatureDirection> directions,
                     std::span<double> result) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The positions whose own features are the given ones (method §2, lossless): the minimum of
/// E(p') = Σ_i |(A_i(p') M_i^-1 - T_i) M_i^½|². Features of a mesh give back that mesh to the
/// precision of the features; of others, the nearest in this sense. The start is the least-squares
/// solution of those equations that leave the pseudo-edges out: they are linear, and a mesh fulfils
/// them exactly.
class LosslessReconstruction {
  public:
    LosslessReconstruction(const TriangleMesh& reference, EdgeWeights weights);
    LosslessReconstruction(LosslessReconstruction&&) noexcept;
    LosslessReconstruction& operator=(LosslessReconstruction&&) noexcept;
    ~LosslessReconstruction();

    /// The fast path for many shapes: quasi-Newton steps with one constant matrix, factorised
    /// once. Arguments, errors and threads as PoissonReconstruction::solve.
    ReconstructedShape solve(std::span<const float> features, std::span<const Point> like = {},
                             Pieces pieces = Pieces::as_in_shape) const;

    /// As PoissonReconstruction::derivatives, for the linear part of solve(): exact where a mesh
    /// has the features and the direction leads to features of meshes, near elsewhere.
    void derivatives(std::span<const float> features, std::span<const FeatureDirection> directions,
                     std::span<double> result) const;

    /// The same minimum by Ceres (Levenberg-Marquardt), with handles. Components that have a handle
    /// stay where their handles put them, the others have the centroid of `like`, by default of the
    /// reference. Throws UsageError for handles that are no vertex
    /// or have a weight that is not positive.
    ReconstructedShape solve_by_ceres(std::span<const float> features,
                                      std::span<const Handle> handles = {},
                                      std::span<const Point> like = {}) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mscomp/acap/edge_weights.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/edit/row_positions.h"
#include "mscomp/model/shape_model.h"

namespace mscomp {

struct VertexFitOptions {
    VertexSolver solver = VertexSolver::poisson;
    int max_steps = 12;  // accepted ones
    /// Converged when a step lowers the objective by a smaller share of it.
    double least_gain = 1e-3;
    /// How far codes may go from their start: to move every code by its deviation costs as much as
    /// this root-mean-square error of a coordinate, the reference in the unit ball. 0: as far as
    /// the vertices pull.
    double prior = 1e-3;
    /// (K) usual size of a change of each code, the standard deviation over the training shapes;
    /// empty means 1 for all. None counts as less than the root mean square of all.
    std::vector<float> code_deviations;
};

/// What a fit may move and what it knows; empty means all. Vertices that are not listed need not be
/// known: their truth is not looked at.
struct FitSubset {
    std::vector<int> codes;     // the others stay at the start
    std::vector<int> vertices;  // at least 3, or the turn of the shape is left open
};

struct FittedShape {
    std::vector<float> codes;     // (K)
    std::vector<Point> vertices;  // (V) of the codes, moved to the truth by the best motion g
    double initial_rms = 0;       // root-mean-square difference of a known coordinate at the start,
    double rms = 0;               // and now, in the unit of the mesh
    int steps = 0;
    bool converged = false;
};

/// Codes whose *vertices* match a shape best: min over z of |g F(Dec(z)) - P|² + prior, F a solver
/// of method §2 where the model decodes to features, g the best rigid motion of the whole for each
/// z: connected components lie to each other as RowPositions says. Levenberg-Marquardt steps over
/// the codes of all levels at once,
/// with the derivative of the decoder, of T = exp(r) S and of the linear solve. The result is never
/// farther from P than the start.
class VertexFit {
  public:
    /// Borrows the model. Throws UsageError if it has another number of vertices than the reference
    /// or `code_deviations` another number of codes, and what the solvers throw.
    VertexFit(const ShapeModel& model, const TriangleMesh& reference, EdgeWeights weights,
              const VertexFitOptions& options = {});
    VertexFit(VertexFit&&) noexcept;
    VertexFit& operator=(VertexFit&&) noexcept;
    ~VertexFit();

    /// The fit of one shape (V) from `start` (K), e.g. the codes of the encoder. Safe to call from
    /// several threads, the same bits for any number of them. Throws MeshError for another V,
    /// UsageError for another K or a subset with what is not there, NumericalError if `truth`,
    /// `start` or what it decodes to is not finite.
    FittedShape fit(std::span<const Point> truth, std::span<const float> start,
                    const FitSubset& subset = {}) const;
    /// Many shapes side by side, `starts` (N,K).
    std::vector<FittedShape> fit(std::span<const std::vector<Point>> truths,
                                 std::span<const float> starts) const;

    /// Positions of codes (K) as RowPositions gives them.
    std::vector<Point> positions(std::span<const float> codes,
                                 std::span<const Point> like = {}) const;
    /// Derivatives of positions() in every code (K,V,3), the centroid kept;
    /// `lossless`: of its linear part.
    std::vector<double> derivatives(std::span<const float> codes) const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace mscomp

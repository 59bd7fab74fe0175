// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "mscomp/model/shape_model.h"
#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"
#include "multiscale/row_map.h"
#include "units/turn_field.h"

namespace mscomp {

/// Rotations of shapes and what these turn by along the edges of a mesh.
class TurningShapes {
  public:
    /// Roots are where shapes turn least, so that little is asked of them. `feature(m)` (V,9) are
    /// unscaled features of shape m.
    template <class Feature>
    TurningShapes(const TriangleMesh& mesh, int shapes, const Feature& feature)
        : field_(mesh),
          rotations_(field_.vertex_count(), shapes, 3),
          turns_(field_.edge_count(), shapes, 3) {
        for (int m = 0; m < shapes; ++m) set(m, feature(m));
        field_ = TurnField(mesh, least_turning());
    }

    const TurnField& field() const { return field_; }
    const MetricRows& rotations() const { return rotations_; }  // (V,3,N) rotation vectors
    const MetricRows& turns() const { return turns_; }          // (E,3,N)
    Eigen::MatrixXd roots() const;                              // (N,3P) of their rotations
    /// Of every edge, where the reference has it.
    static std::vector<Point> middles(const TriangleMesh& mesh, const TurnField& field);

  private:
    void set(int m, std::span<const float> features);
    /// A vertex of each piece.
    std::vector<int> least_turning() const;

    TurnField field_;
    MetricRows rotations_, turns_;
};

/// K components with codes z that turn by Σ_k z_k B_k along edges, exactly none where a unit does
/// not turn, and stretch by Σ_k (z_k A_k + z_k² Q_k), Q only where it turns: what bends one way or
/// the other stretches alike (method §10, space route). Codes are joint least squares over what the
/// turns carry: those of the rotations R of a shape, A R (x - Σ_k z_k B_k) with A of
/// TurnField::added_up. Least squares over the turns themselves would add up along a limb.
class TurningComponents {
  public:
    /// `turns` (E,3); `roots` (K,3P) rotation vectors of the roots for a code of 1; `stretches`
    /// (2K) A and then Q, in mapped features (V,9) whose rotations are zero.
    TurningComponents(TurnField field, BallComponents turns, Eigen::MatrixXd roots,
                      BallComponents stretches);

    const TurnField& field() const { return field_; }
    const BallComponents& turns() const { return turns_; }
    const Eigen::MatrixXd& roots() const { return roots_; }
    const BallComponents& stretches() const { return stretches_; }
    int count() const { return turns_.count(); }
    void set_roots(Eigen::MatrixXd roots) { roots_ = std::move(roots); }
    void set_stretches(BallComponents stretches) { stretches_ = std::move(stretches); }
    /// Components `which` alone, in that order.
    void choose(const std::vector<int>& which);

    /// (K) of features (V,9).
    Eigen::VectorXd codes_of(std::span<const float> features) const;
    /// (N,K).
    Eigen::MatrixXd codes_of(const TurningShapes& shapes) const;
    /// Rotation vectors (V).
    std::vector<Eigen::Vector3d> rotations(std::span<const float> codes) const;
    /// Mapped features (V,9), their rotations zero.
    std::vector<float> stretched(std::span<const float> codes) const;
    /// How features (V,9) change with each code, (K).
    std::vector<CodeColumn> derivatives(std::span<const float> codes, const RowMap& map) const;
    /// The vertices of the edges along which a component turns, rising.
    std::vector<int> vertices_of(int k) const;
    /// Where components turn and stretch.
    std::vector<ComponentPlace> places() const;

  private:
    Eigen::VectorXd codes_of(std::span<const float> vectors, std::span<const float> turns) const;
    TurnField::Direction weighted(std::span<const float> codes) const;
    /// One end of the edge along which it turns most; -1 for a component without.
    int most_turning(int k) const;

    TurnField field_;
    BallComponents turns_;
    Eigen::MatrixXd roots_;
    BallComponents stretches_;
};

struct FittedTurning {
    TurningComponents components;
    Eigen::MatrixXd codes;  // (N,K) of the shapes
};
/// Fitted to shapes with the codes (N,K) of units. Three times turns by least squares, zero where
/// they are below a fifth of their greatest length, and codes by least squares on these; then turns
/// zero below 5 %, twice, fitted to what they carry. Stretches (V,9,N), mapped, by least squares on
/// the last codes. `mesh` is that of the field.
FittedTurning turning_components(const TurningShapes& shapes, const MetricRows& stretches,
                                 const Eigen::MatrixXd& codes, const TriangleMesh& mesh);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "mscomp/model/shape_model.h"
#include "multiscale/ball_components.h"
#include "multiscale/joint_codes.h"
#include "multiscale/metric_rows.h"
#include "multiscale/row_map.h"
#include "units/turn_field.h"

namespace mscomp {

/// Relative rotations of shapes along the edges of a mesh, and what else is needed to go back.
class TurningShapes {
  public:
    /// Roots are where shapes turn least, so that little is asked of them. `feature(m)` (V,9) are
    /// unscaled features of shape m, asked for twice.
    template <class Feature>
    TurningShapes(const TriangleMesh& mesh, int shapes, const Feature& feature)
        : field_(mesh), turns_(field_.edge_count(), shapes, 3) {
        squares_.assign(at(field_.vertex_count()), 0.0);
        for (int m = 0; m < shapes; ++m) add(m, feature(m));
        place_roots(mesh);
        roots_.resize(shapes, 3 * std::ssize(field_.roots()));
        for (int m = 0; m < shapes; ++m) add_roots(m, feature(m));
    }

    const TurnField& field() const { return field_; }
    const MetricRows& turns() const { return turns_; }       // (E,3,N)
    const Eigen::MatrixXd& roots() const { return roots_; }  // (N,3P) rotation vectors
    /// Of every edge, where the reference has it.
    static std::vector<Point> middles(const TriangleMesh& mesh, const TurnField& field);

  private:
    void add(int m, std::span<const float> features);
    void add_roots(int m, std::span<const float> features);
    void place_roots(const TriangleMesh& mesh);

    TurnField field_;
    MetricRows turns_;
    std::vector<double> squares_;  // (V) of the rotation vectors of all shapes
    Eigen::MatrixXd roots_;
};

/// K components with codes z that turn by Σ_k z_k B_k along edges, exactly none where a unit does
/// not turn, and stretch by Σ_k (z_k A_k + z_k² Q_k), Q only where it turns: what bends one way or
/// the other stretches alike (method §10, space route). Codes are joint least squares over the
/// turns.
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
    void set_stretches(BallComponents stretches) { stretches_ = std::move(stretches); }

    /// (K) of features (V,9).
    Eigen::VectorXd codes_of(std::span<const float> features) const;
    /// Codes (N,K) of shapes with these turns (E,3,N).
    Eigen::MatrixXd codes_of(const MetricRows& turns) const;
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
    TurnField::Direction weighted(std::span<const float> codes) const;
    /// One end of the edge along which it turns most; -1 for a component without.
    int most_turning(int k) const;

    TurnField field_;
    BallComponents turns_;
    Eigen::MatrixXd roots_;
    BallComponents stretches_;
    JointCodes joint_codes_;
};

/// Fitted to shapes with the codes (N,K) of units. Three times turns by least squares, zero where
/// they are below a fifth of their greatest length, and codes by least squares on these; then turns
/// once more, zero below 2 %. Stretches (V,9,N), mapped, by least squares on the last codes. `mesh`
/// is that of the field.
TurningComponents turning_components(const TurningShapes& shapes, const MetricRows& stretches,
                                     const Eigen::MatrixXd& codes, const TriangleMesh& mesh);

}  // namespace mscomp

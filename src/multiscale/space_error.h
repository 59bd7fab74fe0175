// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mscomp/acap/feature_layer.h"
#include "mscomp/acap/reconstruct.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/base/metric_scale.h"
#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"

namespace mscomp {

/// How far the positions of some shapes are from what components and codes make of them (method
/// §9, stage B): E = 10⁶ s² / (3V) |p - g P|² with p from the tangential layer, P the positions of
/// the shape's own features, g the best rigid motion and s = 1 / radius: the square of what E_rms
/// is for one shape. Borrows the scale.
class SpaceError {
  public:
    /// Of the scaled features `shapes`; `weights` are the edge weights that they were made with.
    SpaceError(const TriangleMesh& reference, const std::string& weights, const MetricScale& scale,
               const MetricRows& shapes);

    int shape_count() const { return shape_count_; }
    /// E of every shape at codes (K,shapes); overwrites `gradient`, unless it is null, with its
    /// derivative in every scaled feature. The same bits for any number of threads.
    std::vector<double> evaluate(const BallComponents& components, const Eigen::MatrixXd& codes,
                                 MetricRows* gradient = nullptr) const;
    /// H = JᵀJ (K,K) of E in the codes (K) of every shape, the rigid motion eliminated: 2 H is its
    /// Hessian but for second derivatives of positions.
    std::vector<Eigen::MatrixXd> normal_matrices(const BallComponents& components,
                                                 const Eigen::MatrixXd& codes,
                                                 const LosslessReconstruction& lossless) const;

  private:
    /// Unscaled features (count,V,9) of shapes `first` on, whose scaled ones at a vertex are what
    /// scaled(v) gives, (count,9).
    template <class Scaled>
    std::vector<double> unscaled(int count, const Scaled& scaled) const;
    std::vector<double> features(const BallComponents& components, const Eigen::MatrixXd& codes,
                                 int first, int count) const;
    void take_gradient(std::span<const double> by_feature, int first, int count,
                       MetricRows& gradient) const;
    double compare(int m, std::span<const double> positions, std::span<double> gradient) const;

    const MetricScale& scale_;
    int vertices_;
    int shape_count_;
    double weight_;  // 10⁶ s² / (3V)
    FeatureLayer layer_;
    std::vector<std::vector<Point>> targets_;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <span>
#include <vector>

#include "multiscale/ball_components.h"
#include "multiscale/metric_rows.h"

namespace mscomp {

/// Inner products (K,K) of all pairs of components. Sums run over fixed chunks of vertices in
/// parallel, as all below.
Eigen::MatrixXd gram_matrix(const BallComponents& components);
/// How much pairs of components overlap: Σ_v |C_k|²|C_l|².
Eigen::MatrixXd overlaps(const BallComponents& components);
/// Inner products (K,shapes) of components and shapes.
Eigen::MatrixXd products(const BallComponents& components, const MetricRows& rows);
/// The same for one shape, a mapped row (V,width).
Eigen::VectorXd products(const BallComponents& components, std::span<const float> row);

/// Σ_k z_k C_k (V,width) of the first components, as many as there are codes.
std::vector<float> weighted_sum(const BallComponents& components, std::span<const float> codes);

/// Codes by least squares over all components at once: z = (CᵀC + 1e-7 (tr / K) I)⁻¹ Cᵀ x, method
/// §9. Components that are zero have the code 0.
class JointCodes {
  public:
    explicit JointCodes(const BallComponents& components) : JointCodes(gram_matrix(components)) {}
    /// Of the inner products (K,K) of all pairs, CᵀC.
    explicit JointCodes(Eigen::MatrixXd gram);
    /// Of inner products (K,shapes).
    Eigen::MatrixXd solve(const Eigen::MatrixXd& products) const { return factor_.solve(products); }

  private:
    Eigen::LLT<Eigen::MatrixXd> factor_;
};

}  // namespace mscomp

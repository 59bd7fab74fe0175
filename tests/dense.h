// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

// Algebra of whole matrices for tests, compiled once: its templates cost more than most tests.
namespace mscomp::cases {

/// The X of least norm with |A X - B| least; A (m,n), B (m,k), X (n,k).
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// B less its projection onto the columns of A.
Eigen::MatrixXd unexplained(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// AᵀB.
Eigen::MatrixXd inner_products(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

}  // namespace mscomp::cases

// SPDX-License-Identifier: MIT
#include "dense.h"

#include <Eigen/QR>

namespace mscomp::cases {

using Eigen::MatrixXd;

MatrixXd least_squares(const MatrixXd& A, const MatrixXd& B) {
    return A.completeOrthogonalDecomposition().solve(B);
}

MatrixXd unexplained(const MatrixXd& A, const MatrixXd& B) { return B - A * least_squares(A, B); }

MatrixXd inner_products(const MatrixXd& A, const MatrixXd& B) { return A.transpose() * B; }

}  // namespace mscomp::cases

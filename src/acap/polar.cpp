// SPDX-License-Identifier: MIT
#include "polar.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace mscomp {
namespace {

// Below this determinant of T / max|T_ij| the iteration is left for the slower, safer SVD.
constexpr double kWellConditioned = 1e-3;
constexpr double kMirrored = -1e-14;

/// Higham's scaled Newton iteration; `gradient` has a determinant well above zero.
Eigen::Matrix3d rotation_by_newton(const Eigen::Matrix3d& gradient) {
    Eigen::Matrix3d x = gradient;
    for (int iteration = 0; iteration < 30; ++iteration) {
        const Eigen::Matrix3d inverse_transposed = x.inverse().transpose();
        const double scale = std::sqrt(inverse_transposed.norm() / x.norm());
        const Eigen::Matrix3d next = 0.5 * (scale * x + inverse_transposed / scale);
        // Convergence is quadratic: a step of 1e-8 leaves an error of rounding size.
        const bool converged = (next - x).squaredNorm() < 1e-16;
        x = next;
        if (converged) break;
    }
    return x;
}

Eigen::Matrix3d rotation_by_svd(const Eigen::Matrix3d& gradient) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(gradient,
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    if (u.determinant() * svd.matrixV().determinant() < 0) u.col(2) = -u.col(2);
    return u * svd.matrixV().transpose();
}

}  // namespace

PolarDecomposition polar_decomposition(const Eigen::Matrix3d& gradient) {
    const double size = gradient.cwiseAbs().maxCoeff();
    PolarDecomposition result{Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero(), false};
    if (!(size > 0)) return result;
    const Eigen::Matrix3d scaled = gradient / size;
    const double determinant = scaled.determinant();
    result.mirrored = determinant < kMirrored;
    result.rotation =
        determinant > kWellConditioned ? rotation_by_newton(scaled) : rotation_by_svd(scaled);
    const Eigen::Matrix3d stretch = result.rotation.transpose() * gradient;
    result.stretch = 0.5 * (stretch + stretch.transpose());
    return result;
}

}  // namespace mscomp

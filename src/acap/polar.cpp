// SPDX-License-Identifier: MIT
#include "polar.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "polar_lanes.h"

namespace mscomp {
namespace {

constexpr double kMirrored = -1e-14;  // of the determinant of T / max|T_ij|

Eigen::Matrix3d rotation_by_svd(const Eigen::Matrix3d& gradient) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(gradient,
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    if (u.determinant() * svd.matrixV().determinant() < 0) u.col(2) = -u.col(2);
    return u * svd.matrixV().transpose();
}

/// For every matrix: slow, and safe where nearly singular, mirrored, or near the ends of the range
/// of double.
PolarDecomposition polar_by_svd(const Eigen::Matrix3d& gradient) {
    const double size = gradient.cwiseAbs().maxCoeff();
    PolarDecomposition result{Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero(), false};
    if (!(size > 0)) return result;
    const Eigen::Matrix3d scaled = gradient / size;
    result.mirrored = scaled.determinant() < kMirrored;
    result.rotation = rotation_by_svd(scaled);
    const Eigen::Matrix3d stretch = result.rotation.transpose() * gradient;
    result.stretch = 0.5 * (stretch + stretch.transpose());
    return result;
}

template <int kLanes>
void decompose(const Eigen::Matrix3d* gradients, PolarDecomposition* results, int count) {
    PolarLanes<kLanes> lanes;
    for (int lane = 0; lane < kLanes; ++lane) {
        const double* entries = gradients[std::min(lane, count - 1)].data();
        for (int k = 0; k < 9; ++k) lanes.gradient[k][lane] = entries[k];
    }
    decompose(lanes);
    for (int lane = 0; lane < count; ++lane) {
        PolarDecomposition& result = results[lane];
        if (lanes.solved[lane] == 0) {
            result = polar_by_svd(gradients[lane]);
            continue;
        }
        for (int k = 0; k < 9; ++k) {
            result.rotation.data()[k] = lanes.rotation[k][lane];
            result.stretch.data()[k] = lanes.stretch[kSymmetricEntry[k]][lane];
        }
        result.mirrored = false;
    }
}

}  // namespace

PolarDecomposition polar_decomposition(const Eigen::Matrix3d& gradient) {
    PolarDecomposition result;
    decompose<1>(&gradient, &result, 1);
    return result;
}

void polar_decompositions(std::span<const Eigen::Matrix3d> gradients,
                          std::span<PolarDecomposition> results) {
    constexpr std::size_t kLanes = 16;
    for (std::size_t first = 0; first < results.size(); first += kLanes) {
        const std::size_t count = std::min(kLanes, results.size() - first);
        decompose<kLanes>(&gradients[first], &results[first], static_cast<int>(count));
    }
}

}  // namespace mscomp

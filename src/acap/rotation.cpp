// SPDX-License-Identifier: MIT
#include "rotation.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/feature_set.h"

namespace mscomp {

Eigen::Matrix3d rotation_exp(const Eigen::Vector3d& rotation_vector) {
    const double half = 0.5 * rotation_vector.norm();
    // sin(x)/x is 1 to rounding below 1e-8; above, the quotient is accurate.
    const double half_sinc = half > 1e-8 ? 0.5 * std::sin(half) / half : 0.5;
    const Eigen::Vector3d v = half_sinc * rotation_vector;
    return Eigen::Quaterniond(std::cos(half), v.x(), v.y(), v.z()).toRotationMatrix();
}

Eigen::Matrix3d rotation_left_jacobian(const Eigen::Vector3d& rotation_vector) {
    // J_l = I + (1 - cos t)/t² [r]x + (t - sin t)/t³ [r]x²: the second quotient cancels near 0.
    const double square = rotation_vector.squaredNorm(), angle = std::sqrt(square);
    const double half = 0.5 * angle;
    const double half_sinc = half > 1e-8 ? std::sin(half) / half : 1.0;
    const double second =
        angle > 0.1 ? (angle - std::sin(angle)) / (square * angle)
                    : 1.0 / 6 - square * (1.0 / 120 - square * (1.0 / 5040 - square / 362880));
    const Eigen::Vector3d& r = rotation_vector;
    Eigen::Matrix3d cross;
    cross << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
    return Eigen::Matrix3d::Identity() + 0.5 * half_sinc * half_sinc * cross +
           second * cross * cross;
}

Eigen::Vector3d rotation_log(const Eigen::Matrix3d& rotation) {
    Eigen::Quaterniond q(rotation);
    q.normalize();
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    const double sine = q.vec().norm();
    if (!(sine > 0)) return Eigen::Vector3d::Zero();
    return (2 * std::atan2(sine, q.w()) / sine) * q.vec();
}

Eigen::Matrix3d stretch_of_feature(const Feature& feature) {
    Eigen::Matrix3d stretch;
    stretch << feature[3], feature[4], feature[5],  //
        feature[4], feature[6], feature[7],         //
        feature[5], feature[7], feature[8];
    return stretch;
}

Eigen::Matrix3d gradient_of_feature(const Feature& feature) {
    return rotation_exp(feature.head<3>()) * stretch_of_feature(feature);
}

std::vector<Eigen::Matrix3d> gradients_of_features(std::span<const float> features,
                                                   std::size_t vertex_count) {
    if (features.size() != vertex_count * kFeatureDim) {
        throw MeshError(fmt::format("{} feature values, wanted {} x {} for this reference",
                                    features.size(), vertex_count, kFeatureDim));
    }
    std::vector<Eigen::Matrix3d> gradients(vertex_count);
    for (std::size_t i = 0; i < vertex_count; ++i) {
        const float* feature = features.data() + i * kFeatureDim;
        gradients[i] = gradient_of_feature(
            Eigen::Map<const Eigen::Matrix<float, 9, 1>>(feature).cast<double>());
        if (!gradients[i].allFinite()) {
            throw NumericalError(fmt::format("feature of vertex {} is not finite", i));
        }
    }
    return gradients;
}

}  // namespace mscomp

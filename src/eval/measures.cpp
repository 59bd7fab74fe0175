// SPDX-License-Identifier: MIT
#include "mscomp/eval/measures.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using Positions = Eigen::Matrix<double, 3, Eigen::Dynamic>;

Positions centered(const std::vector<Point>& points) {
    const Eigen::Map<const Positions> all(points.front().data(), 3,
                                          static_cast<Eigen::Index>(points.size()));
    return all.colwise() - all.rowwise().mean();
}

}  // namespace

RmsError::RmsError(const std::vector<Point>& reference) : scale_(0) {
    if (reference.empty()) throw MeshError("E_rms of a reference without vertices");
    scale_ = 1 / centered(reference).colwise().norm().maxCoeff();
}

void RmsError::add(const std::vector<Point>& truth, const std::vector<Point>& result) {
    if (truth.size() != result.size() || truth.empty()) {
        throw MeshError(
            fmt::format("E_rms between {} and {} vertices", truth.size(), result.size()));
    }
    const Positions p = centered(truth), q = centered(result);
    // Kabsch: the rotation of q onto p, det +1.
    const Eigen::Matrix3d covariance = p * q.transpose();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d flip = Eigen::Matrix3d::Identity();
    flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
    const Eigen::Matrix3d rotation = svd.matrixU() * flip * svd.matrixV().transpose();
    squares_ += (p - rotation * q).squaredNorm() * scale_ * scale_;
    coordinates_ += 3.0 * static_cast<double>(truth.size());
    ++shapes_;
}

double RmsError::value() const {
    if (shapes_ == 0) return std::numeric_limits<double>::quiet_NaN();
    return 1000 * std::sqrt(squares_ / coordinates_);
}

double relative_squared_error(std::span<const float> truth, std::span<const float> result) {
    double error = 0, size = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const double difference = static_cast<double>(truth[i]) - static_cast<double>(result[i]);
        error += difference * difference;
        size += static_cast<double>(truth[i]) * static_cast<double>(truth[i]);
    }
    return error == 0 ? 0 : error / size;
}

}  // namespace mscomp

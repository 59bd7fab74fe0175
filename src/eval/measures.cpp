// SPDX-License-Identifier: MIT
#include "mscomp/eval/measures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

double square_distance(const Point& p, const Point& q) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += (p[k] - q[k]) * (p[k] - q[k]);
    return sum;
}

Point centroid(const std::vector<Point>& points) {
    Point sum{0, 0, 0};
    for (const Point& p : points) {
        for (std::size_t k = 0; k < 3; ++k) sum[k] += p[k] / static_cast<double>(points.size());
    }
    return sum;
}

}  // namespace

RmsError::RmsError(const std::vector<Point>& reference) : scale_(0) {
    if (reference.empty()) throw MeshError("E_rms of a reference without vertices");
    const Point center = centroid(reference);
    double farthest = 0;
    for (const Point& p : reference) farthest = std::max(farthest, square_distance(p, center));
    scale_ = 1 / std::sqrt(farthest);
}

void RmsError::add(const std::vector<Point>& truth, const std::vector<Point>& result) {
    if (truth.size() != result.size() || truth.empty()) {
        throw MeshError(
            fmt::format("E_rms between {} and {} vertices", truth.size(), result.size()));
    }
    const std::vector<Point> aligned = moved(result, best_rigid_motion(result, truth));
    double squares = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) squares += square_distance(truth[i], aligned[i]);
    squares_ += squares * scale_ * scale_;
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

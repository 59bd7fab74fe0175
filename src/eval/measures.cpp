// SPDX-License-Identifier: MIT
#include "mscomp/eval/measures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mscomp/acap/alignment.h"
#include "mscomp/base/error.h"
#include "mscomp/base/points.h"

namespace mscomp {
namespace {

double root_mean_square_1000(double squares, double coordinates) {
    return 1000 * std::sqrt(squares / coordinates);
}

}  // namespace

std::vector<Point> aligned_to(const std::vector<Point>& truth, const std::vector<Point>& result) {
    if (truth.size() != result.size() || truth.empty()) {
        throw MeshError(
            fmt::format("measuring a result of {} vertices, the truth has {}; wanted as many, and "
                        "at least one",
                        result.size(), truth.size()));
    }
    return moved(result, best_rigid_motion(result, truth));
}

std::vector<double> vertex_distances(const std::vector<Point>& truth,
                                     const std::vector<Point>& result) {
    const std::vector<Point> aligned = aligned_to(truth, result);
    std::vector<double> distances(truth.size());
    for (std::size_t i = 0; i < truth.size(); ++i) {
        distances[i] = std::sqrt(square_distance(truth[i], aligned[i]));
    }
    return distances;
}

RmsError::RmsError(const std::vector<Point>& reference) : scale_(0) {
    if (reference.empty()) throw MeshError("E_rms of a reference without vertices");
    scale_ = unit_ball_scale(reference);
}

double RmsError::add(const std::vector<Point>& truth, const std::vector<Point>& result) {
    const std::vector<Point> aligned = aligned_to(truth, result);
    double squares = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) squares += square_distance(truth[i], aligned[i]);
    squares *= scale_ * scale_;
    const double coordinates = 3.0 * static_cast<double>(truth.size());
    squares_ += squares;
    coordinates_ += coordinates;
    ++shapes_;
    return root_mean_square_1000(squares, coordinates);
}

double RmsError::value() const {
    if (shapes_ == 0) return std::numeric_limits<double>::quiet_NaN();
    return root_mean_square_1000(squares_, coordinates_);
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

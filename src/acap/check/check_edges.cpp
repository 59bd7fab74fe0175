// SPDX-License-Identifier: MIT
#include "check_edges.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "acap/edge_weights.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

constexpr double kStrayRatio = 6.0;
constexpr double kBetterShifted = 2.0;
constexpr double kWorthExplaining = 3e-3;  // mean square of log ratios about their mean
constexpr double kLargestLog = 30.0;

double median_of(std::vector<double> values) {
    if (values.empty()) return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

double variance_of(const std::vector<double>& values) {
    if (values.empty()) return 0.0;
    const auto count = static_cast<double>(values.size());
    const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
    double sum = 0;
    for (const double value : values) sum += (value - mean) * (value - mean);
    return sum / count;
}

double distance(const Point& a, const Point& b) { return (as_vector(a) - as_vector(b)).norm(); }

}  // namespace

Point centroid_of(const std::vector<Point>& points) {
    Point sum{};
    for (const Point& point : points) {
        for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += point[axis];
    }
    for (double& value : sum) value /= static_cast<double>(std::max<std::size_t>(points.size(), 1));
    return sum;
}

double rms_radius(const std::vector<Point>& points) {
    const Point center = centroid_of(points);
    double sum = 0;
    for (const Point& point : points) {
        const double length = distance(point, center);
        sum += length * length;
    }
    return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(points.size(), 1)));
}

EdgeStretchTest::EdgeStretchTest(const std::vector<Point>& reference, const OneRings& rings)
    : vertex_count_(reference.size()),
      all_edges_(rings.neighbors.size() / 2),
      order_(reference, rings),
      radius_(rms_radius(reference)) {
    for (int i = 0; i < rings.vertex_count(); ++i) {
        const auto place = at(i);
        for (int k = rings.offsets[place]; k < rings.offsets[place + 1]; ++k) {
            const int j = rings.neighbors[at(k)];
            if (j < i) continue;
            const double length = distance(reference[place], reference[at(j)]);
            if (length > 0) edges_.push_back({i, j, std::log(length)});
        }
    }
}

std::vector<double> EdgeStretchTest::log_ratios(const std::vector<Point>& shape,
                                                std::size_t shift) const {
    std::vector<double> ratios;
    ratios.reserve(edges_.size());
    for (const Edge& edge : edges_) {
        const std::size_t a = (at(edge.from) + shift) % vertex_count_;
        const std::size_t b = (at(edge.to) + shift) % vertex_count_;
        const double ratio = std::log(distance(shape[a], shape[b])) - edge.log_length;
        ratios.push_back(std::clamp(ratio, -kLargestLog, kLargestLog));
    }
    return ratios;
}

/// Where vertices are numbered along the surface, a shift of the numbers leaves most edges as they
/// are. But then undoing it makes the lengths agree, which no deformation does.
bool EdgeStretchTest::fits_better_shifted(const std::vector<Point>& shape,
                                          const std::vector<double>& ratios) const {
    const double spread = variance_of(ratios);
    if (!(spread > kWorthExplaining)) return false;
    const std::size_t half = vertex_count_ / 2;
    for (const std::size_t shift :
         {std::size_t{1}, vertex_count_ - 1, half, vertex_count_ - half}) {
        if (variance_of(log_ratios(shape, shift)) * kBetterShifted < spread) return true;
    }
    return false;
}

EdgeStretch EdgeStretchTest::compare(const std::vector<Point>& shape) const {
    EdgeStretch result;
    const double radius = rms_radius(shape);
    if (edges_.empty() || !(radius > 0) || !(radius_ > 0)) {
        result.size_ratio = radius_ > 0 ? radius / radius_ : 1.0;
        result.median_ratio = result.size_ratio;
        return result;
    }
    const std::vector<double> ratios = log_ratios(shape, 0);
    const double median = median_of(ratios);
    result.median_ratio = std::exp(median);
    result.size_ratio = radius / radius_;

    constexpr double kNone = std::numeric_limits<double>::infinity();
    std::vector<double> least(vertex_count_, kNone), most(vertex_count_, -kNone);
    for (std::size_t k = 0; k < edges_.size(); ++k) {
        for (const int vertex : {edges_[k].from, edges_[k].to}) {
            const auto i = at(vertex);
            least[i] = std::min(least[i], ratios[k] - median);
            most[i] = std::max(most[i], ratios[k] - median);
        }
    }
    const auto is_stray = [&](int vertex) {
        const double value = least[at(vertex)];
        return value > std::log(kStrayRatio) && value < kNone;
    };
    result.first_permuted = order_.first_out_of_place(shape);
    if (result.first_permuted < 0 && fits_better_shifted(shape, ratios)) result.first_permuted = 0;
    result.permuted = result.first_permuted >= 0;
    if (result.permuted) return result;
    for (int i = 0; i < static_cast<int>(vertex_count_); ++i) {
        const auto place = at(i);
        if (is_stray(i)) result.stray.push_back(i);
        if (most[place] < -std::log(kStrayRatio) && most[place] > -kNone)
            result.shrunk.push_back(i);
    }
    return result;
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "pinched_rings.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "acap/edge_weights.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

// A ring of this share of the usual width is pinched; one of twice the usual width is stretched.
constexpr double kPinched = 0.25;
constexpr double kStretched = 2.0;

double ring_width(const std::vector<Point>& points, const OneRings& rings, std::size_t vertex) {
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (int place = rings.offsets[vertex]; place < rings.offsets[vertex + 1]; ++place) {
        const auto j = at(rings.neighbors[at(place)]);
        const Eigen::Vector3d edge = as_vector(points[j]) - as_vector(points[vertex]);
        spread += edge * edge.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread, Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(eigen.eigenvalues()[1], 0.0));
}

double median_ring_width(const std::vector<Point>& points, const OneRings& rings) {
    if (points.empty()) return 0;
    std::vector<double> widths;
    widths.reserve(points.size());
    for (std::size_t v = 0; v < points.size(); ++v) {
        widths.push_back(ring_width(points, rings, v));
    }
    const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
    std::nth_element(widths.begin(), middle, widths.end());
    return *middle;
}

}  // namespace

PinchedRings::PinchedRings(const std::vector<Point>& reference, const OneRings& rings)
    : reference_(reference), rings_(rings), usual_width_(median_ring_width(reference, rings)) {}

bool PinchedRings::opens_a_pinch(const std::vector<Point>& shape, int vertex,
                                 double size_ratio) const {
    return ring_width(reference_, rings_, at(vertex)) < kPinched * usual_width_ &&
           ring_width(shape, rings_, at(vertex)) < kStretched * size_ratio * usual_width_;
}

}  // namespace mscomp

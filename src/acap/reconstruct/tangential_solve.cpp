// SPDX-License-Identifier: MIT
#include "tangential_solve.h"

#include <cmath>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

// Keeps the matrix definite where the equations leave a vertex free; what it changes is taken back
// by the second of the steps below wherever they do not.
constexpr double kTangentialShare = 1e-6;
constexpr int kSteps = 3;

std::vector<Eigen::Vector3d> tangential_factors(const FeatureEquations& equations) {
    const OneRings& rings = equations.gradients().rings();
    std::vector<Eigen::Vector3d> factors = equations.edge_factors();
    for (std::size_t i = 0; i < equations.tangential().size(); ++i) {
        for (int place = rings.offsets[i]; place < rings.offsets[i + 1]; ++place) {
            Eigen::Vector3d& factor = factors[at(place)];
            factor = equations.tangential()[i] * factor;
        }
    }
    return factors;
}

std::vector<Eigen::Vector3d> pulls_of(const FeatureEquations& equations,
                                      const std::vector<Eigen::Vector3d>& factors) {
    const OneRings& rings = equations.gradients().rings();
    const std::size_t count = equations.tangential().size();
    const std::vector<Eigen::Matrix3d> roots =
        equations.wanted(std::vector<Eigen::Matrix3d>(count, Eigen::Matrix3d::Identity()));
    std::vector<Eigen::Vector3d> pulls(factors.size());
    for (std::size_t v = 0; v < count; ++v) {
        for (int place = rings.offsets[v]; place < rings.offsets[v + 1]; ++place) {
            const auto k = at(place);
            pulls[k] = roots[v] * factors[k];
        }
    }
    return pulls;
}

MatrixEntries matrix_of(const FeatureEquations& equations,
                        const std::vector<Eigen::Vector3d>& factors) {
    MatrixEntries entries;
    add_ring_squares(equations.gradients().rings(), factors, entries);
    add_laplacian(equations.gradients().rings(), equations.gradients().weights(), kTangentialShare,
                  entries);
    return entries;
}

}  // namespace

TangentialSolve::TangentialSolve(const FeatureEquations& equations, const std::vector<int>& anchors)
    : equations_(equations),
      factors_(tangential_factors(equations)),
      pulls_(pulls_of(equations, factors_)),
      system_(matrix_of(equations, factors_), equations.gradients().rings().vertex_count(), anchors,
              "the matrix of the lossless reconstruction") {}

/// -r_i P_i.
Eigen::Matrix3d TangentialSolve::missing(std::size_t vertex,
                                         const std::vector<Eigen::Matrix3d>& wanted,
                                         const std::vector<Point>& shape) const {
    const OneRings& rings = equations_.gradients().rings();
    Eigen::Matrix3d result = wanted[vertex] * equations_.tangential()[vertex];
    for (int place = rings.offsets[vertex]; place < rings.offsets[vertex + 1]; ++place) {
        const auto k = at(place);
        const auto j = at(rings.neighbors[k]);
        result -= (as_vector(shape[j]) - as_vector(shape[vertex])) * factors_[k].transpose();
    }
    return result;
}

double TangentialSolve::residual(const std::vector<Eigen::Matrix3d>& wanted,
                                 const std::vector<Point>& shape) const {
    double squares = 0, size = 0;
    for (std::size_t i = 0; i < shape.size(); ++i) {
        squares += missing(i, wanted, shape).squaredNorm();
        size += (wanted[i] * equations_.tangential()[i]).squaredNorm();
    }
    return size > 0 ? std::sqrt(squares / size) : 0.0;
}

/// Minus half the derivative of Σ_i |r_i P_i|².
std::vector<Point> TangentialSolve::descent(const std::vector<Eigen::Matrix3d>& wanted,
                                            const std::vector<Point>& shape) const {
    const OneRings& rings = equations_.gradients().rings();
    std::vector<Point> result(shape.size(), Point{});
    const auto add = [&](std::size_t vertex, const Eigen::Vector3d& value) {
        Eigen::Map<Eigen::Vector3d> target(result[vertex].data());
        target += value;
    };
    for (std::size_t i = 0; i < shape.size(); ++i) {
        const Eigen::Matrix3d left = missing(i, wanted, shape);
        for (int place = rings.offsets[i]; place < rings.offsets[i + 1]; ++place) {
            const auto k = at(place);
            const Eigen::Vector3d pull = left * factors_[k];
            add(at(rings.neighbors[k]), pull);
            add(i, -pull);
        }
    }
    return result;
}

void TangentialSolve::apply(const std::vector<Eigen::Matrix3d>& wanted,
                            std::vector<Point>& shape) const {
    for (int step = 0; step < kSteps; ++step) {
        const std::vector<Point> change = system_.solve(descent(wanted, shape));
        for (std::size_t i = 0; i < shape.size(); ++i) {
            for (std::size_t axis = 0; axis < 3; ++axis) shape[i][axis] += change[i][axis];
        }
    }
}

}  // namespace mscomp

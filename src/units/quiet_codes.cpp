// SPDX-License-Identifier: MIT
#include "units/quiet_codes.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// What is near zero beside the largest, smaller and smaller.
constexpr double kNearZero[] = {1, 0.5, 0.2, 0.1, 0.05};
constexpr double kPower = 0.5;

/// w with the weights `weights` of all places, here · w = 1.
VectorXd weighted_readout(const QuietSearch& search, const VectorXd& weights,
                          const VectorXd& here) {
    MatrixXd rooted(search.places.rows(), search.places.cols());
    for (Index i = 0; i < rooted.rows(); ++i) {
        rooted.row(i) = std::sqrt(weights[i / search.width]) * search.places.row(i);
    }
    MatrixXd hessian = search.damping.asDiagonal();
    hessian.selfadjointView<Eigen::Lower>().rankUpdate(rooted.transpose());
    const VectorXd solved =
        Eigen::LLT<MatrixXd>(hessian.selfadjointView<Eigen::Lower>()).solve(here);
    return solved / here.dot(solved);
}

/// |Y_i w|, or Y_i w where a place is one row; the largest is 1.
VectorXd sizes_at(const QuietSearch& search, const VectorXd& weights) {
    const VectorXd values = search.places * weights;
    if (search.width == 1) return values / values.cwiseAbs().maxCoeff();
    VectorXd sizes(values.size() / search.width);
    for (Index i = 0; i < sizes.size(); ++i) {
        sizes[i] = values.segment(i * search.width, search.width).norm();
    }
    return sizes / sizes.maxCoeff();
}

}  // namespace

ShapeBasis shape_basis(const MatrixXd& gram, int most) {
    // Of the largest square: positions are float, and what moves by a hundredth of their size has
    // five digits left.
    constexpr double kRounding = 1e-8;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(gram);
    const VectorXd squares = solver.eigenvalues().reverse().cwiseMax(0);
    Index count = std::min<Index>(most, gram.rows());
    while (count > 0 && !(squares[count - 1] > kRounding * squares[0])) --count;
    const double spread = std::sqrt(static_cast<double>(gram.rows()));
    return {spread * solver.eigenvectors().rowwise().reverse().leftCols(count),
            squares.head(count).cwiseSqrt(), std::sqrt(squares.sum())};
}

QuietReadout quiet_readout(const QuietSearch& search, const VectorXd& here) {
    QuietReadout found;
    VectorXd weights = VectorXd::Ones(search.places.rows() / search.width);
    for (const double near : kNearZero) {
        for (int round = 0; round < search.rounds; ++round) {
            found.weights = weighted_readout(search, weights, here);
            found.sizes = sizes_at(search, found.weights);
            found.loudness = 0;
            for (Index i = 0; i < weights.size(); ++i) {
                const double size = found.sizes[i];
                const double square = size * size + near * near;
                found.loudness += std::pow(square, kPower / 2);
                weights[i] = (size < 0 ? search.below_zero : 1) * std::pow(square, kPower / 2 - 1);
            }
        }
    }
    return found;
}

MatrixXd quiet_codes(const ShapeBasis& basis, double noise) {
    const auto count = static_cast<double>(basis.places.rows());
    constexpr double kBelowZero = 10;
    const QuietSearch search{basis.places, 1,
                             count * (noise * basis.size / basis.sizes.array()).square(), 5,
                             kBelowZero};
    std::vector<Index> moved;
    for (Index n = 0; n < basis.places.rows(); ++n) {
        if (basis.places.row(n).norm() > 1e-9) moved.push_back(n);
    }
    MatrixXd codes(basis.places.rows(), static_cast<Index>(moved.size()));
    parallel_for(std::ssize(moved), [&](std::int64_t i) {
        codes.col(i) = quiet_readout(search, basis.places.row(moved[at(i)]).transpose()).sizes;
    });
    return codes;
}

}  // namespace mscomp

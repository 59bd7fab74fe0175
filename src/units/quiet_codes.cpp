// SPDX-License-Identifier: MIT
#include "units/quiet_codes.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "mscomp/base/index.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/parallel.h"
#include "units/weighted_squares.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// What is near zero beside the largest, smaller and smaller.
constexpr double kNearZero[] = {1, 0.5, 0.2, 0.1, 0.05};

/// |Y_i w|, or Y_i w where a place is one row; the largest is 1.
VectorXd sizes_of(const QuietSearch& search, const VectorXd& values) {
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

std::vector<QuietReadout> quiet_readouts(const QuietSearch& search, const MatrixXd& here) {
    constexpr int kLanes = WeightedSquares::kLanes;
    const WeightedSquares squares(search.places, search.width);
    std::vector<QuietReadout> found(at(here.cols()));
    parallel_for((here.cols() + kLanes - 1) / kLanes, [&](std::int64_t batch) {
        const Index first = batch * kLanes, count = std::min<Index>(kLanes, here.cols() - first);
        Eigen::Matrix<double, Eigen::Dynamic, kLanes, Eigen::RowMajor> weights;
        weights.setOnes(search.places.rows() / search.width, kLanes);
        std::vector<double> sums(squares.sums_size());
        MatrixXd hessian(here.rows(), here.rows()), readouts(here.rows(), count);
        for (const double near : kNearZero) {
            for (int round = 0; round < search.rounds; ++round) {
                throw_if_interrupted(kSearchInterrupted);
                squares.add_up(weights.data(), sums.data());
                for (Index lane = 0; lane < count; ++lane) {
                    squares.lower(sums.data(), static_cast<int>(lane), hessian);
                    hessian.diagonal() += search.damping;
                    const Eigen::LLT<Eigen::Ref<MatrixXd>> factor(hessian);
                    const VectorXd solved = factor.solve(here.col(first + lane));
                    readouts.col(lane) = solved / here.col(first + lane).dot(solved);
                }
                const MatrixXd values = search.places * readouts;
                for (Index lane = 0; lane < count; ++lane) {
                    QuietReadout& own = found[at(first + lane)];
                    own.sizes = sizes_of(search, values.col(lane));
                    own.loudness = 0;
                    for (Index i = 0; i < own.sizes.size(); ++i) {
                        const double size = own.sizes[i];
                        const double square = size * size + near * near;
                        const double loud = std::sqrt(std::sqrt(square));  // to the power p / 2
                        own.loudness += loud;
                        weights(i, lane) = (size < 0 ? search.below_zero : 1) * loud / square;
                    }
                }
            }
        }
        for (Index lane = 0; lane < count; ++lane) {
            found[at(first + lane)].weights = readouts.col(lane);
        }
    });
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
    const std::vector<QuietReadout> found =
        quiet_readouts(search, basis.places(moved, Eigen::all).transpose());
    MatrixXd codes(basis.places.rows(), std::ssize(found));
    for (std::size_t i = 0; i < found.size(); ++i)
        codes.col(static_cast<Index>(i)) = found[i].sizes;
    return codes;
}

}  // namespace mscomp

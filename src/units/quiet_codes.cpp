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

// What is near zero beside the largest code, smaller and smaller, and rounds with each.
constexpr double kNearZero[] = {1, 0.5, 0.2, 0.1, 0.05};
constexpr int kRounds = 5;
constexpr double kPower = 0.5;
constexpr double kBelowZero = 10;  // times the weight of what is above

/// Y w with the weights `weights` of all shapes, 1 at the shape `own`.
VectorXd weighted_codes(const ShapeBasis& basis, const VectorXd& damping, const VectorXd& weights,
                        Index own) {
    const MatrixXd rooted = weights.cwiseSqrt().asDiagonal() * basis.places;
    MatrixXd hessian = damping.asDiagonal();
    hessian.selfadjointView<Eigen::Lower>().rankUpdate(rooted.transpose());
    const VectorXd here = basis.places.row(own).transpose();
    const VectorXd solved =
        Eigen::LLT<MatrixXd>(hessian.selfadjointView<Eigen::Lower>()).solve(here);
    return basis.places * (solved / here.dot(solved));
}

VectorXd quiet_code(const ShapeBasis& basis, const VectorXd& damping, Index own) {
    VectorXd weights = VectorXd::Ones(basis.places.rows()), codes;
    for (const double near : kNearZero) {
        for (int round = 0; round < kRounds; ++round) {
            codes = weighted_codes(basis, damping, weights, own);
            codes /= codes.cwiseAbs().maxCoeff();
            for (Index n = 0; n < codes.size(); ++n) {
                const double weight = std::pow(codes[n] * codes[n] + near * near, kPower / 2 - 1);
                weights[n] = codes[n] < 0 ? kBelowZero * weight : weight;
            }
        }
    }
    return codes;
}

}  // namespace

ShapeBasis shape_basis(const MatrixXd& gram, int most) {
    constexpr double kRounding = 1e-12;  // of the largest square
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(gram);
    const VectorXd squares = solver.eigenvalues().reverse().cwiseMax(0);
    Index count = std::min<Index>(most, gram.rows());
    while (count > 0 && !(squares[count - 1] > kRounding * squares[0])) --count;
    const double spread = std::sqrt(static_cast<double>(gram.rows()));
    return {spread * solver.eigenvectors().rowwise().reverse().leftCols(count),
            squares.head(count).cwiseSqrt(), std::sqrt(squares.sum())};
}

MatrixXd quiet_codes(const ShapeBasis& basis, double noise) {
    const auto count = static_cast<double>(basis.places.rows());
    const VectorXd damping = count * (noise * basis.size / basis.sizes.array()).square();
    std::vector<Index> moved;
    for (Index n = 0; n < basis.places.rows(); ++n) {
        if (basis.places.row(n).norm() > 1e-9) moved.push_back(n);
    }
    MatrixXd codes(basis.places.rows(), static_cast<Index>(moved.size()));
    parallel_for(std::ssize(moved),
                 [&](std::int64_t i) { codes.col(i) = quiet_code(basis, damping, moved[at(i)]); });
    return codes;
}

}  // namespace mscomp

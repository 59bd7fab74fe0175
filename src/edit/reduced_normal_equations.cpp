// SPDX-License-Identifier: MIT
#include "reduced_normal_equations.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace mscomp {
namespace {

// Of the largest pivot: what is below is rounding of a sum of squares.
constexpr double kSingular = 1e-14;

using Columns = Eigen::Map<const Eigen::MatrixXd>;

/// e x (p_i - centroid) for the three axes e, (3V,3).
Eigen::MatrixXd turns_of(const std::vector<Point>& positions) {
    const auto count = static_cast<Eigen::Index>(positions.size());
    const Eigen::Map<const Eigen::Matrix3Xd> p(positions.front().data(), 3, count);
    const Eigen::Vector3d center = p.rowwise().mean();
    Eigen::MatrixXd turns(3 * count, 3);
    for (Eigen::Index i = 0; i < count; ++i) {
        const Eigen::Vector3d q = p.col(i) - center;
        turns.middleRows<3>(3 * i) << 0, q.z(), -q.y(),  //
            -q.z(), 0, q.x(),                            //
            q.y(), -q.x(), 0;
    }
    return turns;
}

/// Σ_i of the coordinates of every column, (3,K).
Eigen::Matrix3Xd sums_of(const Columns& J) {
    Eigen::Matrix3Xd sums(3, J.cols());
    for (Eigen::Index k = 0; k < J.cols(); ++k) {
        sums.col(k) =
            Eigen::Map<const Eigen::Matrix3Xd>(J.col(k).data(), 3, J.rows() / 3).rowwise().sum();
    }
    return sums;
}

}  // namespace

NormalEquations reduced_normal_equations(std::span<const double> derivatives,
                                         const std::vector<Point>& positions,
                                         const std::vector<Point>& residuals) {
    const auto rows = static_cast<Eigen::Index>(3 * positions.size());
    const Columns J(derivatives.data(), rows, static_cast<Eigen::Index>(derivatives.size()) / rows);
    NormalEquations result;
    result.H.setZero(J.cols(), J.cols());
    result.H.selfadjointView<Eigen::Lower>().rankUpdate(J.transpose());
    result.g = J.transpose() * Eigen::Map<const Eigen::VectorXd>(residuals.front().data(), rows);
    // About the centroid turns and translations are orthogonal. A straight or single-point shape
    // has turns that do nothing: hence the pseudoinverse.
    const Eigen::MatrixXd turns = turns_of(positions);
    const Eigen::MatrixXd by_turns = turns.transpose() * J;
    const Eigen::Matrix3d inertia = turns.transpose() * turns;
    const Eigen::Matrix3Xd sums = sums_of(J);
    result.H.triangularView<Eigen::Lower>() -=
        by_turns.transpose() * inertia.completeOrthogonalDecomposition().pseudoInverse() * by_turns;
    result.H.triangularView<Eigen::Lower>() -=
        sums.transpose() * sums * (3.0 / static_cast<double>(rows));
    result.H = Eigen::MatrixXd(result.H.selfadjointView<Eigen::Lower>());
    return result;
}

SmallResiduals small_residuals(const NormalEquations& equations, double squares) {
    const Eigen::Index count = equations.g.size();
    SmallResiduals result{Eigen::VectorXd::Zero(count + 1),
                          Eigen::MatrixXd::Zero(count + 1, count)};
    // P H Pᵀ = L D Lᵀ, so that R = D^½ Lᵀ P.
    const Eigen::LDLT<Eigen::MatrixXd> factor(equations.H);
    const Eigen::VectorXd pivots = factor.vectorD();
    const double smallest = kSingular * pivots.cwiseAbs().maxCoeff();
    const Eigen::VectorXd forward = factor.matrixL().solve(factor.transpositionsP() * equations.g);
    const Eigen::MatrixXd upper =
        Eigen::MatrixXd(factor.matrixU()) *
        (factor.transpositionsP() * Eigen::MatrixXd::Identity(count, count));
    for (Eigen::Index n = 0; n < count; ++n) {
        if (!(pivots[n] > smallest)) continue;
        const double root = std::sqrt(pivots[n]);
        result.values[n] = forward[n] / root;
        result.derivative.row(n) = root * upper.row(n);
    }
    const double explained = result.values.squaredNorm();
    result.values[count] = std::sqrt(std::max(squares - explained, 0.0));
    return result;
}

}  // namespace mscomp

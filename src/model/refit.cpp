// SPDX-License-Identifier: MIT
#include "model/refit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

/// What single precision leaves of the differences of changes that are the same.
constexpr double kRidge = 1e-9;
/// What a component that stands for another one has of their direction at least.
constexpr double kLeastPart = 0.3;

/// Turns columns a and b of `columns` by the rotation whose first column is `direction`.
template <class Matrix>
void turn_columns(Matrix& columns, Index a, Index b, const Vector2d& direction) {
    const VectorXd first = columns.col(a), second = columns.col(b);
    columns.col(a) = direction[0] * first + direction[1] * second;
    columns.col(b) = direction[0] * second - direction[1] * first;
}

/// How well code b follows from code a, through 0, in shapes that the factor was not fitted to: the
/// root of the share of its squares that is predicted. A shape that alone decides the factor
/// predicts nothing.
double predicted(const VectorXd& a, const VectorXd& b) {
    const double squares = a.squaredNorm(), all = b.squaredNorm();
    if (squares == 0 || all == 0) return 0;
    const double factor = a.dot(b) / squares;
    double missed = 0;
    for (Index n = 0; n < a.size(); ++n) {
        const double others = 1 - a[n] * a[n] / squares;
        const double off = others > 1e-9 ? (b[n] - factor * a[n]) / others : b[n];
        missed += off * off;
    }
    return std::sqrt(std::max(0.0, 1 - missed / all));
}

/// What a correlation over so many shapes is at least, three standard errors below (Fisher).
double surely(double correlation, Index shapes) {
    constexpr double kErrors = 3;
    if (shapes < 3) return 0;
    const double deviation = 1 / std::sqrt(static_cast<double>(shapes - 2));
    return std::max(0.0, std::tanh(std::atanh(std::min(1.0, correlation)) - kErrors * deviation));
}

/// How well the codes predict each other, (K,K).
MatrixXd predicted_each_other(const MatrixXd& codes) {
    const Index count = codes.cols();
    const Index shapes = (codes.rowwise().squaredNorm().array() > 0).count();
    MatrixXd result = MatrixXd::Identity(count, count);
    for (Index a = 0; a < count; ++a) {
        for (Index b = 0; b < a; ++b) {
            const double both = std::min(predicted(codes.col(a), codes.col(b)),
                                         predicted(codes.col(b), codes.col(a)));
            result(a, b) = result(b, a) = surely(both, shapes);
        }
    }
    return result;
}

}  // namespace

Refit::Refit(const MatrixXd& products, const MatrixXd& codes)
    : lengths_(products.diagonal().cwiseMax(0).cwiseSqrt()),
      alike_(predicted_each_other(codes)),
      codes_(codes * lengths_.asDiagonal()),
      reading_(MatrixXd::Identity(products.rows(), products.rows())),
      direction_(MatrixXd::Identity(products.rows(), products.rows())),
      is_left_(at(products.rows()), 1),
      has_others_(at(products.rows()), 0) {
    const Index count = products.rows();
    squares_ = std::max(0.0, (codes * products).cwiseProduct(codes).sum());
    movements_ = codes_.colwise().squaredNorm().transpose();
    VectorXd scale = lengths_.unaryExpr([](double x) { return x > 0 ? 1 / x : 0; });
    cosines_ = scale.asDiagonal() * products * scale.asDiagonal();
    for (Index k = 0; k < count; ++k) cosines_(k, k) = 1;
    MatrixXd damped = cosines_;
    damped.diagonal().array() += kRidge;
    inverse_ = damped.llt().solve(MatrixXd::Identity(count, count));
}

void Refit::reduce(double share, double alike) {
    for (Index k = 0; k < movements_.size(); ++k) {
        if (!(movements_[k] > 0)) take({static_cast<int>(k), -1, 0, {}});
    }
    while (true) {
        const RefitStep step = cheapest(alike);
        if (step.component < 0 || !(lost_ + step.cost <= share)) return;
        take(step);
    }
}

void Refit::drop_all(const std::vector<int>& components) {
    for (const int k : components) take({k, -1, cost(k), {}});
}

std::vector<int> Refit::left() const {
    std::vector<int> result;
    for (std::size_t k = 0; k < is_left_.size(); ++k) {
        if (is_left_[k] != 0) result.push_back(static_cast<int>(k));
    }
    return result;
}

VectorXd Refit::direction(int k) const {
    VectorXd codes = direction_.col(k) / direction_(k, k);
    for (Index i = 0; i < codes.size(); ++i) {
        if (lengths_[i] > 0) codes[i] *= lengths_[k] / lengths_[i];
    }
    return codes;
}

VectorXd Refit::reading(int k) const {
    const VectorXd codes = reading_.col(k) * direction_(k, k);
    return codes.cwiseProduct(lengths_) / (lengths_[k] > 0 ? lengths_[k] : 1);
}

double Refit::cost(int k) const { return squares_ > 0 ? squares_lost_without(k) / squares_ : 0; }

double Refit::squares_lost_without(Index k) const {
    return codes_.col(k).squaredNorm() / inverse_(k, k);
}

Likeness Refit::likeness(int k, int other) const {
    return {alike_(k, other), std::min(1.0, std::abs(cosines_(k, other)))};
}

/// By what it moves; of two that move the same the later one.
bool Refit::is_weaker(int k, int other) const {
    return std::tuple(movements_[k], -k) < std::tuple(movements_[other], -other);
}

RefitStep Refit::cheapest(double alike) const {
    RefitStep best{-1, -1, 0, {}};
    for (const int k : left()) {
        const RefitStep step = cheapest_without(k, alike);
        const bool is_better = best.component < 0 || step.cost < best.cost ||
                               (step.cost == best.cost && is_weaker(k, best.component));
        if (is_better) best = step;
    }
    return best;
}

/// What costs least of making k part of a stronger one that it is like; where there is none, or
/// others were merged into it, of dropping it.
RefitStep Refit::cheapest_without(int k, double alike) const {
    RefitStep best{k, -1, cost(k), {}};
    if (has_others_[at(k)] != 0) return best;
    for (const int other : left()) {
        if (other == k || !is_weaker(k, other)) continue;
        const Likeness like = likeness(k, other);
        if (!(like.most() >= alike)) continue;
        const Joint both = joint(k, other);
        if (!(both.direction[0] >= kLeastPart)) continue;
        const double cost = both.cost / squares_;
        if (best.into < 0 || cost < best.cost) best = {k, other, cost, like};
    }
    return best;
}

Refit::Joint Refit::joint(int k, int into) const {
    Eigen::Matrix<double, Eigen::Dynamic, 2> codes(codes_.rows(), 2);
    codes << codes_.col(into), codes_.col(k);
    Matrix2d inverse;
    inverse << inverse_(into, into), inverse_(into, k), inverse_(k, into), inverse_(k, k);
    const Matrix2d squares = codes.transpose() * codes;
    // Vectors w of M w = λ P w, the largest λ last.
    const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix2d> solver(squares, inverse);
    Joint result;
    result.direction = (squares * solver.eigenvectors().col(1)).normalized();
    if (result.direction[0] < 0) result.direction *= -1;
    const Vector2d other(-result.direction[1], result.direction[0]);
    result.cost = (codes * other).squaredNorm() / other.dot(inverse * other);
    return result;
}

void Refit::take(const RefitStep& step) {
    lost_ += step.cost;
    steps_.push_back(step);
    if (step.into < 0) {
        drop(step.component);
    } else {
        merge(step.component, step.into);
    }
}

void Refit::drop(int k) {
    const VectorXd column = inverse_.col(k);
    const double own = column[k];
    codes_ -= VectorXd(codes_.col(k) / own) * column.transpose();
    reading_ -= VectorXd(reading_.col(k) / own) * column.transpose();
    inverse_ -= (column / own) * column.transpose();
    codes_.col(k).setZero();
    reading_.col(k).setZero();
    inverse_.col(k).setZero();
    inverse_.row(k).setZero();
    is_left_[at(k)] = 0;
}

void Refit::merge(int k, int into) {
    const Vector2d direction = joint(k, into).direction;
    turn_columns(codes_, into, k, direction);
    turn_columns(reading_, into, k, direction);
    turn_columns(direction_, into, k, direction);
    turn_columns(inverse_, into, k, direction);
    inverse_.transposeInPlace();
    turn_columns(inverse_, into, k, direction);
    has_others_[at(into)] = 1;
    drop(k);
}

}  // namespace mscomp

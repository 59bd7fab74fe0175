// SPDX-License-Identifier: MIT
#include "units/unit_codes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "mscomp/base/index.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// (ZᵀZ)⁻¹, with what keeps it from being singular.
Eigen::LLT<MatrixXd> normal_equations(const MatrixXd& codes) {
    constexpr double kDamping = 1e-10;
    MatrixXd normal = codes.transpose() * codes;
    normal.diagonal().array() += kDamping * normal.trace() / static_cast<double>(normal.rows());
    return Eigen::LLT<MatrixXd>(normal);
}

/// Part of the square of a column that the others leave.
double left_by_others(const MatrixXd& codes, const std::vector<int>& kept, int k) {
    std::vector<int> others = kept;
    std::erase(others, k);
    const MatrixXd beside = columns_of(codes, others);
    const VectorXd own = codes.col(k);
    const VectorXd by = normal_equations(beside).solve(beside.transpose() * own);
    return (own - beside * by).squaredNorm() / own.squaredNorm();
}

/// Of a shape with itself and of components C: minimises |x - Cᵀ z|² over z >= 0, with CCᵀ and Cx.
void lower_coordinates(const MatrixXd& square, const VectorXd& product, Eigen::Ref<VectorXd> z) {
    constexpr int kSweeps = 20;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        for (Index k = 0; k < z.size(); ++k) {
            if (!(square(k, k) > 0)) continue;
            z[k] = std::max(0.0, z[k] + (product[k] - square.col(k).dot(z)) / square(k, k));
        }
    }
}

}  // namespace

MatrixXd columns_of(const MatrixXd& matrix, const std::vector<int>& which) {
    MatrixXd result(matrix.rows(), static_cast<Index>(which.size()));
    for (std::size_t i = 0; i < which.size(); ++i) {
        result.col(static_cast<Index>(i)) = matrix.col(which[i]);
    }
    return result;
}

MatrixXd correlations(MatrixXd codes, MatrixXd others) {
    for (MatrixXd* of : {&codes, &others}) {
        const Eigen::RowVectorXd whole = of->colwise().norm();
        of->rowwise() -= of->colwise().mean().eval();
        for (Index k = 0; k < of->cols(); ++k) {
            const double size = of->col(k).norm();
            of->col(k) *= size > 1e-9 * whole[k] ? 1 / size : 0;
        }
    }
    return (codes.transpose() * others).cwiseAbs();
}

UnitCodes chosen(const UnitCodes& units, const std::vector<int>& which) {
    UnitCodes result{columns_of(units.codes, which), {}};
    for (const int k : which) result.votes.push_back(units.votes[at(k)]);
    return result;
}

UnitCodes agreed(const MatrixXd& candidates) {
    constexpr double kSame = 0.95;
    constexpr int kLeastVotes = 2;
    constexpr double kRounding = 1e-9;
    const MatrixXd units = candidates.colwise().normalized();
    const MatrixXd cosines = (units.transpose() * units).cwiseAbs();
    const Eigen::RowVectorXd loud = candidates.colwise().lpNorm<1>();
    std::vector<char> is_left(at(candidates.cols()), 1);
    UnitCodes result;
    std::vector<int> leaders;
    for (;;) {
        Index best = -1;
        int most = 0;
        // The order of the shapes decides nothing: two alone are as near to each other.
        double nearest = 0;  // sum of the cosines
        for (Index i = 0; i < cosines.cols(); ++i) {
            if (is_left[at(i)] == 0) continue;
            int votes = 0;
            double sum = 0;
            for (Index j = 0; j < cosines.cols(); ++j) {
                if (is_left[at(j)] == 0 || !(cosines(j, i) >= kSame)) continue;
                ++votes;
                sum += cosines(j, i);
            }
            if (votes == 0) continue;  // it is zero
            const bool is_as_near = std::abs(sum - nearest) <= kRounding * sum;
            if (votes > most ||
                (votes == most && (is_as_near ? loud[i] < loud[best] : sum > nearest))) {
                most = votes;
                nearest = sum;
                best = i;
            }
        }
        if (most < kLeastVotes) break;
        for (Index j = 0; j < cosines.cols(); ++j) {
            if (cosines(j, best) >= kSame) is_left[at(j)] = 0;
        }
        leaders.push_back(static_cast<int>(best));
        result.votes.push_back(most);
    }
    result.codes = columns_of(candidates, leaders);
    return result;
}

UnitCodes without_predicted(UnitCodes units) {
    constexpr double kLeft = 0.02;
    std::vector<int> kept(at(units.codes.cols()));
    std::iota(kept.begin(), kept.end(), 0);
    // The most votes come first.
    for (std::size_t i = kept.size(); kept.size() > 1 && i-- > 0;) {
        if (left_by_others(units.codes, kept, kept[i]) > kLeft) continue;
        kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(i));
        i = kept.size();
    }
    return chosen(units, kept);
}

double unexplained(const MatrixXd& gram, const MatrixXd& codes) {
    const double all = gram.trace();
    if (codes.cols() == 0 || !(all > 0)) return 1;
    const MatrixXd products = codes.transpose() * gram * codes;
    return std::max(0.0, 1 - normal_equations(codes).solve(products).trace() / all);
}

UnitCodes refitted(const MatrixXd& gram, UnitCodes units) {
    constexpr int kTurns = 15;
    MatrixXd codes = units.codes.cwiseMax(0);
    for (int round = 0; round < kTurns && codes.cols() > 0; ++round) {
        // C = (ZᵀZ)⁻¹ Zᵀ X.
        const MatrixXd by_shapes = normal_equations(codes).solve(codes.transpose());
        const MatrixXd products = by_shapes * gram;
        const MatrixXd square = products * by_shapes.transpose();
        for (Index n = 0; n < codes.rows(); ++n) {
            VectorXd z = codes.row(n).transpose();
            lower_coordinates(square, products.col(n), z);
            codes.row(n) = z.transpose();
        }
    }
    std::vector<int> kept;
    for (Index k = 0; k < codes.cols(); ++k) {
        const double most = codes.col(k).maxCoeff();
        if (!(most > 0)) continue;
        codes.col(k) /= most;
        kept.push_back(static_cast<int>(k));
    }
    units.codes = codes;
    return chosen(units, kept);
}

std::vector<bool> found_again(const UnitCodes& all, const UnitCodes& part,
                              const std::vector<int>& which) {
    constexpr double kSame = 0.9;
    std::vector<bool> result(at(all.codes.cols()), false);
    if (all.count() == 0 || part.count() == 0) return result;
    MatrixXd here(static_cast<Index>(which.size()), all.codes.cols());
    for (std::size_t n = 0; n < which.size(); ++n) {
        here.row(static_cast<Index>(n)) = all.codes.row(which[n]);
    }
    MatrixXd table = correlations(here, part.codes);
    Index k = 0, l = 0;
    while (table.size() > 0 && table.maxCoeff(&k, &l) >= kSame) {
        result[at(k)] = true;
        table.row(k).setConstant(-1);
        table.col(l).setConstant(-1);
    }
    return result;
}

}  // namespace mscomp

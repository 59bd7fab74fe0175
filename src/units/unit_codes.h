// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

namespace mscomp {

/// Columns `which` of a matrix, in that order.
Eigen::MatrixXd columns_of(const Eigen::MatrixXd& matrix, const std::vector<int>& which);

/// |correlations| (K,L) of codes (N,K) and (N,L) of the same shapes; 0 where a code does not vary.
Eigen::MatrixXd correlations(Eigen::MatrixXd codes, Eigen::MatrixXd others);

/// Codes of units, and how many read-outs agreed on each.
struct UnitCodes {
    Eigen::MatrixXd codes;   // (N,K), the largest of each unit 1
    std::vector<int> votes;  // (K)

    int count() const { return static_cast<int>(votes.size()); }
};

/// Units `which`, in that order.
UnitCodes chosen(const UnitCodes& units, const std::vector<int>& which);

/// Candidates (N,M) that have a |cosine| of at least 0.95 are one; that with the most such
/// neighbours, the nearest of equals, stands for them. Those of which there is only one are left
/// out; the most votes first.
UnitCodes agreed(const Eigen::MatrixXd& candidates);

/// Without those that the others predict (R² of at least 0.98 without an offset), the fewest votes
/// first.
UnitCodes without_predicted(UnitCodes units);

/// Part of the sum of the squares of all shapes that codes do not explain; `gram` (N,N) are inner
/// products of shapes.
double unexplained(const Eigen::MatrixXd& gram, const Eigen::MatrixXd& codes);

/// Components by least squares and codes by least squares without negative ones, in turn; codes
/// that come to nothing are left out.
UnitCodes refitted(const Eigen::MatrixXd& gram, UnitCodes units);

/// For each unit of `all` whether one of `part`, whose shapes are `which` of all, has codes that
/// correlate with its codes there by at least 0.9; every one of `part` serves one.
std::vector<bool> found_again(const UnitCodes& all, const UnitCodes& part,
                              const std::vector<int>& which);

}  // namespace mscomp

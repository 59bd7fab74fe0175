// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <vector>

namespace mscomp {

/// How two components are alike.
struct Likeness {
    double codes = 0;    // what one code says of the other in shapes left out, 0 to 1
    double changes = 0;  // |cosine| of what they change

    double most() const { return codes > changes ? codes : changes; }
};

/// One component fewer.
struct RefitStep {
    int component = -1;
    int into = -1;    // it was merged into this one; -1: it was dropped
    double cost = 0;  // what the step lost, as a share of all squares
    Likeness likeness;
};

/// Fewer components that say nearly what all of them say of some shapes, X_n = Σ_k Z_nk C_k,
/// relative to the reference.
///
/// The components that are left are C_S = Dᵀ C: each one of them, or one with others that move
/// along with it. They stay as they are; their codes are refitted by least squares, Z_S = Z R. What
/// is lost then is Σ_n |X_n - Σ_S Z_S C_S|². All of it follows from inner products of the C_k.
///
/// Without component k the others lose |Z_S,k|² / P_kk more, P = (C_S C_Sᵀ)⁻¹, and
/// Z_S ← Z_S - Z_S,k P_k / P_kk, R likewise, P ← P - P_k P_kᵀ / P_kk. Two components become one
/// that moves both along d by such a step, too, in the basis of d and another direction. Of all d
/// the one that loses least is d = M w, w the first eigenvector of (P_ij)⁻¹ M, M = Z_ijᵀ Z_ij.
class Refit {
  public:
    /// Of inner products (K,K) and codes (N,K) that are 0 for the reference.
    Refit(const Eigen::MatrixXd& products, const Eigen::MatrixXd& codes);

    /// Takes away what costs least, one after the other, as long as all that is lost stays within
    /// `share` of the squares: components that change nothing, others, or, in place of one that is
    /// like a stronger one by at least `alike`, what makes one of both. Of two that cost the same
    /// the weaker one goes.
    void reduce(double share, double alike);
    /// Takes these away, in this order.
    void drop_all(const std::vector<int>& components);

    const std::vector<RefitStep>& steps() const { return steps_; }
    /// Components that are left, rising.
    std::vector<int> left() const;
    /// How far the codes (K) of the unit that is left as component k go where its own goes by 1.
    Eigen::VectorXd direction(int k) const;
    /// Its refitted code is the inner product of this (K) and all codes, in the unit of code k.
    Eigen::VectorXd reading(int k) const;
    /// What it would cost to take it away, too, as a share of all squares.
    double cost(int k) const;
    /// Σ_n |X_n|².
    double squares() const { return squares_; }
    /// What has been lost, as a share of them.
    double lost() const { return lost_; }

  private:
    struct Joint {
        Eigen::Vector2d direction = Eigen::Vector2d::Zero();
        double cost = 0;
    };

    RefitStep cheapest(double alike) const;
    RefitStep cheapest_without(int k, double alike) const;
    Joint joint(int k, int into) const;
    double squares_lost_without(Eigen::Index k) const;
    Likeness likeness(int k, int other) const;
    bool is_weaker(int k, int other) const;
    void take(const RefitStep& step);
    void drop(int k);
    void merge(int k, int into);

    Eigen::VectorXd lengths_;    // (K) of the changes
    Eigen::MatrixXd cosines_;    // (K,K) of the changes
    Eigen::MatrixXd alike_;      // (K,K) Likeness::codes
    Eigen::VectorXd movements_;  // (K) squares that each moves
    double squares_ = 0;         // of the shapes
    // Below changes have length 1.
    Eigen::MatrixXd inverse_;    // (K,K) P
    Eigen::MatrixXd codes_;      // (N,K) Z_S
    Eigen::MatrixXd reading_;    // (K,K) R
    Eigen::MatrixXd direction_;  // (K,K) D
    std::vector<char> is_left_;
    std::vector<char> has_others_;  // whether others were merged into it
    std::vector<RefitStep> steps_;
    double lost_ = 0;
};

}  // namespace mscomp

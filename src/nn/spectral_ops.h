// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/aligned.h"
#include "mscomp/base/distance_rows.h"
#include "mscomp/base/index.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/nn/spectral_config.h"
#include "nn/ops.h"
#include "nn/tape.h"

// The ops of the spectral VAE. Tensors are those of ops.h for one autoencoder: rows (1,V,d,lanes),
// codes (1,K,lanes), component weights (1,K,V,d'). Moments (2,K,lanes) are mu and, behind it,
// s = C_std f.
namespace mscomp::nn {

/// The scaled Laplacian 2 L / lambda_max - I, L = I - D^-1/2 W D^-1/2, of a mesh; symmetric. A
/// vertex without neighbours has L_ii = 1.
template <class T>
class ScaledLaplacian {
  public:
    /// W is 0/1 without `edge_weights`; else they are one positive number for each entry of
    /// one_rings.neighbors, the same for both directions of an edge.
    ScaledLaplacian(OneRings one_rings, std::span<const double> edge_weights, LambdaMax lambda_max);

    int vertex_count() const { return rings_.vertex_count(); }
    double lambda_max() const { return lambda_max_; }
    const OneRings& rings() const { return rings_; }
    std::span<const T> weights() const { return weights_; }  // one per neighbour
    T diagonal() const { return diagonal_; }

    /// to_v = scale (L x)_v - previous_v for v in [begin, end); x and previous (null: 0) are whole
    /// rows of `row` numbers per vertex, a multiple of 8; `to` starts at vertex begin.
    void apply(const T* x, int row, T scale, const T* previous, int begin, int end, T* to) const;
    /// T_degree of x from the two before it, as `apply`: L x for 1, 2 L x - before above.
    void next_term(int degree, const T* x, const T* before, int row, int begin, int end,
                   T* to) const;

  private:
    OneRings rings_;
    std::vector<T> weights_;
    T diagonal_;
    double lambda_max_;
};

/// y = act(sum_h T_h(L) x theta_h): x (1,V,d,L), theta (H,d,d') -> (1,V,d',L). [B] eq. 3.
template <class T>
Var cheb_conv(Tape<T>& tape, const ScaledLaplacian<T>& laplacian, Var x, Var theta,
              Activation activation);

/// theta_h^T for every h: (H,d,d') -> (H,d',d).
template <class T>
Var transpose_filters(Tape<T>& tape, Var theta);

/// mu = C f and s = C_std f: f (1,V,d',L), C and C_std (1,K,V,d') -> moments (2,K,L).
template <class T>
Var project_moments(Tape<T>& tape, Var f, Var component_weights, Var spread_weights);

/// f_i = sum_k C_k,i z_k for any number of channels: codes (1,K,L), C (1,K,V,d') -> (1,V,d',L).
template <class T>
Var expand_codes(Tape<T>& tape, Var codes, Var component_weights);

/// (mu, s + offset): moments (2,K,L) -> the same.
template <class T>
Var offset_spread(Tape<T>& tape, Var moments, double offset);

/// z = mu + sigma noise, sigma = exp(s/2) or s: moments (2,K,L), noise (1,K,L) -> (1,K,L). [B]
/// eq. 4.
template <class T>
Var sample_codes(Tape<T>& tape, Var moments, Var noise, Spread spread);

/// (1/n) sum over codes and active lanes of 1/2 (mu^2 + sigma^2 - 1 - ln(sigma^2 + epsilon)):
/// moments (2,K,L) -> (1). `epsilon` counts for a linear sigma only.
template <class T>
Var kl_divergence(Tape<T>& tape, Var moments, Spread spread, double epsilon,
                  const LaneMask<T>& lanes);

/// The centres of the components and the distances from them; reaches are learned, so unlike
/// SparsityRows no range is kept here.
template <class T>
class ComponentCenters {
  public:
    /// Borrows `distances`.
    ComponentCenters(DistanceRows& distances, CenterRule rule)
        : distances_(distances), rule_(rule) {}

    /// Brings centres and lengths up to date for component weights (K,V,channels); `ranges` (K) are
    /// what `settle` judges the penalty by.
    void focus(std::span<const T> component_weights, int channels, std::span<const T> ranges);

    /// |C_k,i| at the last focus, (V).
    std::span<const T> lengths(std::int64_t k) const;
    /// Distances from the centre of component k at the last focus, (V).
    std::span<const double> distances(std::int64_t k) const { return rows_[at(k)]; }

    /// Centres of the last focus or as set; -1 where there is none yet.
    const std::vector<int>& centers() const { return centers_; }
    void set_centers(std::vector<int> centers) { centers_ = std::move(centers); }

  private:
    DistanceRows& distances_;
    CenterRule rule_;
    std::vector<int> centers_;
    std::vector<std::span<const double>> rows_;
    AlignedVector<T> lengths_;  // (K,V)
};

/// Omega = (1/K) sum_k sum_i Delta_ik |C_k,i|, Delta_ik = 1 where the distance of vertex i from the
/// centre of k exceeds d_k: C (1,K,V,d'), ranges d (K) -> (1). [B] eq. 6 and 7. The slope of Delta
/// is a definition: dDelta_ik/dd_k = -1, see StraightThrough. Centres are constant for
/// differentiation; without `differentiable` only d gets a gradient (the proximal step does the
/// rest). `centers` is borrowed.
template <class T>
Var learned_sparsity(Tape<T>& tape, Var component_weights, Var ranges, ComponentCenters<T>& centers,
                     StraightThrough straight_through, bool differentiable);

/// Phi(d): (K) -> (1); the slope of max(d, 0) and of |d| at 0 is 0. [B] eq. 8.
template <class T>
Var range_term(Tape<T>& tape, Var ranges, RangeTerm kind);

/// T_h(L) x of a batch for h = 0 .. H-1; constant while the batch is, so computed once for it.
template <class T>
class BatchTerms {
  public:
    BatchTerms(const ScaledLaplacian<T>& laplacian, int order, int lanes);

    /// x (V,9,lanes) is borrowed until the next call; zero from lane `active` on.
    void prepare(std::span<const T> x, int active);
    int active() const { return active_; }
    int order() const { return static_cast<int>(terms_.size()); }
    std::int64_t vertex_count() const { return laplacian_.vertex_count(); }
    int lanes() const { return lanes_; }
    const T* term(int degree) const { return terms_[at(degree)]; }

  private:
    const ScaledLaplacian<T>& laplacian_;
    int lanes_;
    int active_ = 0;
    std::vector<const T*> terms_;
    AlignedVector<T> own_;  // (H-1,V,9,lanes)
};

/// cheb_conv with tanh and project_moments in one pass, for nine channels on both sides and terms
/// of a constant x: theta (H,9,9), C and C_std (1,K,V,9) -> moments (2,K,L). `terms` is borrowed.
template <class T>
Var spectral_encoder(Tape<T>& tape, const BatchTerms<T>& terms, Var theta, Var component_weights,
                     Var spread_weights);

/// expand_codes, cheb_conv with tanh and squared_error in one op, for nine channels on both sides
/// and a constant x: codes (1,K,L), C (1,K,V,9), theta (H,9,9), x (1,V,9,L) -> (1).
template <class T>
Var spectral_decoder(Tape<T>& tape, const ScaledLaplacian<T>& laplacian, Var codes,
                     Var component_weights, Var theta, Var x, const LaneMask<T>& lanes);

}  // namespace mscomp::nn

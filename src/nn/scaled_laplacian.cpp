// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "kernels/spectral_kernels.h"
#include "mscomp/base/index.h"
#include "mscomp/base/random.h"
#include "nn/spectral_ops.h"

namespace mscomp::nn {
namespace {

/// Entries of D^-1/2 W D^-1/2, one for each neighbour.
std::vector<double> normalized_adjacency(const OneRings& rings,
                                         std::span<const double> edge_weights) {
    const auto weight = [&](int place) {
        return edge_weights.empty() ? 1.0 : edge_weights[at(place)];
    };
    const auto count = at(rings.vertex_count());
    std::vector<double> root(count, 0.0);  // D^-1/2
    for (std::size_t v = 0; v < count; ++v) {
        double degree = 0;
        for (int place = rings.offsets[v]; place < rings.offsets[v + 1]; ++place)
            degree += weight(place);
        if (degree > 0) root[v] = 1 / std::sqrt(degree);
    }
    std::vector<double> entries;
    entries.reserve(rings.neighbors.size());
    for (std::size_t v = 0; v < count; ++v) {
        for (int place = rings.offsets[v]; place < rings.offsets[v + 1]; ++place) {
            const int neighbor = rings.neighbors[at(place)];
            entries.push_back(root[v] * weight(place) * root[at(neighbor)]);
        }
    }
    return entries;
}

/// Largest eigenvalue of the symmetric tridiagonal matrix with these entries, by bisection on the
/// signs of the leading minors.
double largest_of_tridiagonal(const std::vector<double>& diagonal,
                              const std::vector<double>& beside) {
    double low = diagonal[0], high = diagonal[0];
    for (std::size_t i = 0; i < diagonal.size(); ++i) {
        const double reach =
            (i > 0 ? beside[i - 1] : 0) + (i + 1 < diagonal.size() ? beside[i] : 0);
        low = std::min(low, diagonal[i] - reach);
        high = std::max(high, diagonal[i] + reach);
    }
    const auto is_above_all = [&](double x) {
        double pivot = 1;
        for (std::size_t i = 0; i < diagonal.size(); ++i) {
            pivot = x - diagonal[i] - (i > 0 ? beside[i - 1] * beside[i - 1] / pivot : 0);
            if (!(pivot > 0)) return false;
        }
        return true;
    };
    for (int round = 0; round < 120 && low < high; ++round) {
        const double middle = low + (high - low) / 2;
        if (middle == low || middle == high) break;
        (is_above_all(middle) ? high : low) = middle;
    }
    return high;
}

/// Largest eigenvalue of L = I - adjacency, by Lanczos from a random vector. Copies of eigenvalues
/// that rounding brings do not harm the largest.
double largest_eigenvalue(const OneRings& rings, const std::vector<double>& adjacency) {
    const auto count = at(rings.vertex_count());
    constexpr int kMostRounds = 4000, kCheckEvery = 10;
    const CounterRandom random(1, 0);
    std::vector<double> current(count), before(count, 0.0), next(count);
    double norm = 0;
    for (std::size_t v = 0; v < count; ++v) {
        current[v] = random.normal(v);
        norm += current[v] * current[v];
    }
    for (double& x : current) x /= std::sqrt(norm);
    std::vector<double> diagonal, beside;
    double beta = 0, found = 0;
    for (int round = 1; round <= kMostRounds; ++round) {
        double alpha = 0;
        for (std::size_t v = 0; v < count; ++v) {
            double sum = current[v];
            for (int place = rings.offsets[v]; place < rings.offsets[v + 1]; ++place) {
                const auto n = at(place);
                sum -= adjacency[n] * current[at(rings.neighbors[n])];
            }
            next[v] = sum;
            alpha += sum * current[v];
        }
        diagonal.push_back(alpha);
        double square = 0;
        for (std::size_t v = 0; v < count; ++v) {
            next[v] -= alpha * current[v] + beta * before[v];
            square += next[v] * next[v];
        }
        beta = std::sqrt(square);
        const bool is_invariant = beta < 1e-13;  // the vectors so far span all that is needed
        if (is_invariant || round % kCheckEvery == 0) {
            const double largest = largest_of_tridiagonal(diagonal, beside);
            if (is_invariant || std::abs(largest - found) <= 1e-15 * largest) return largest;
            found = largest;
        }
        beside.push_back(beta);
        for (double& x : next) x /= beta;
        std::swap(before, current);
        std::swap(current, next);
    }
    return found;
}

}  // namespace

template <class T>
ScaledLaplacian<T>::ScaledLaplacian(OneRings one_rings, std::span<const double> edge_weights,
                                    LambdaMax lambda_max)
    : rings_(std::move(one_rings)) {
    assert(edge_weights.empty() || edge_weights.size() == rings_.neighbors.size());
    const std::vector<double> adjacency = normalized_adjacency(rings_, edge_weights);
    lambda_max_ = lambda_max == LambdaMax::two ? 2.0 : largest_eigenvalue(rings_, adjacency);
    diagonal_ = static_cast<T>(2 / lambda_max_ - 1);
    weights_.reserve(adjacency.size());
    for (const double entry : adjacency) {
        weights_.push_back(static_cast<T>(-2 / lambda_max_ * entry));
    }
}

template <class T>
void ScaledLaplacian<T>::apply(const T* x, int row, T scale, const T* previous, int begin, int end,
                               T* to) const {
    const GraphMatrix<T> matrix{vertex_count(), rings_.offsets.data(), rings_.neighbors.data(),
                                weights_.data(), diagonal_};
    spectral_kernels<T>().laplacian(matrix, x, row, scale, previous, begin, end, to);
}

template <class T>
void ScaledLaplacian<T>::next_term(int degree, const T* x, const T* before, int row, int begin,
                                   int end, T* to) const {
    if (degree == 1) {
        apply(x, row, T{1}, nullptr, begin, end, to);
    } else {
        apply(x, row, T{2}, before, begin, end, to);
    }
}

template class ScaledLaplacian<float>;
template class ScaledLaplacian<double>;

}  // namespace mscomp::nn

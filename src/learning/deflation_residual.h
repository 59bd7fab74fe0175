// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/aligned.h"
#include "mscomp/base/feature_set.h"

namespace mscomp {

inline constexpr std::int64_t kRowDim = kFeatureDim;  // numbers per vertex, for sizes

/// A direction of unit length at some of the vertices of a residual, or all zero.
struct DeflationDirection {
    std::vector<int> places;     // rising indices into DeflationResidual::vertices()
    std::vector<double> values;  // (places,9)
    std::vector<double> codes;   // (shapes), how far each shape goes along it

    /// The energy that it explains: the sum of the squared codes.
    double explained() const;
};

/// What is left of the rows of some shapes while components are taken out of them, at the vertices
/// where there is anything. Sums run over fixed chunks of vertices in parallel.
class DeflationResidual {
  public:
    DeflationResidual(std::int64_t vertices, std::int64_t shapes);

    /// Shapes `first` to `first + count - 1`: `of` the numbers of the rows (V,9,lanes). Of rows
    /// with less than nine `channels` the others are left zero.
    template <class T>
    void fill(const T* rows, std::int64_t lanes, std::int64_t first, std::int64_t count,
              double (*of)(double), std::int64_t channels = kFeatureDim);
    /// Forgets vertices with less than 1e-5 of the mean energy of a vertex, once all shapes are
    /// there: all of them together are 1e-5 of the whole, and what components would hold there is
    /// noise that a support has to carry.
    void drop_silent_vertices();

    /// Of what drop_silent_vertices left.
    double energy() const;
    /// The vertex with the largest remaining energy.
    int strongest_vertex() const;
    /// What is left at each of vertices().
    std::span<const double> energies() const { return energies_; }
    /// Vertices that directions are about, rising.
    std::span<const int> vertices() const { return vertices_; }

    /// The direction that explains most energy among those that vanish at all but `places`, by
    /// power iterations from the main direction of `vertex`; all zero where nothing is left.
    DeflationDirection main_direction(int vertex, std::vector<int> places) const;
    void subtract(const DeflationDirection& direction);
    /// The vertex where a direction is longest, the first one where there are several.
    int longest_vertex(const DeflationDirection& direction) const;

  private:
    const double* row(std::int64_t i) const { return values_.data() + i * shapes_; }
    double energy_of(std::int64_t place) const;
    std::vector<double> strongest_channel(int vertex) const;
    std::vector<double> correlations(std::span<const int> places) const;
    std::vector<double> correlated(std::span<const int> places,
                                   std::span<const double> codes) const;

    std::int64_t shapes_;
    std::vector<int> vertices_;
    AlignedVector<double> values_;  // (vertices,9,shapes)
    std::vector<double> energies_;  // (vertices)
};

}  // namespace mscomp

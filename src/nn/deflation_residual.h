// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace mscomp::nn {

/// What is left of the encoder output of one autoencoder while components are taken out of it, at
/// the vertices where there is anything. Sums run over fixed chunks of vertices in parallel.
class DeflationResidual {
  public:
    DeflationResidual(std::int64_t vertices, std::int64_t shapes);

    /// Shapes `first` to `first + count - 1`: tanh of the rows (V,9,lanes) of the autoencoder's
    /// input, which is what the encoder gives while its convolution is the identity.
    template <class T>
    void fill(const T* rows, std::int64_t lanes, std::int64_t first, std::int64_t count);
    /// Forgets vertices with less than 1e-5 of the mean energy of a vertex, once all shapes are
    /// there: all of them together are 1e-5 of the whole, and what components would hold there is
    /// noise that a support has to carry.
    void drop_silent_vertices();

    double energy() const;
    /// The vertex with the largest remaining energy.
    int strongest_vertex() const;
    /// Vertices that `direction`s are about, rising.
    std::span<const int> vertices() const { return vertices_; }

    /// The unit-length direction (vertices().size(), 9) that explains most energy among those that
    /// vanish where `is_free` is zero, by power iterations from the main direction of `vertex`; all
    /// zero where nothing is left.
    std::vector<double> main_direction(int vertex, std::span<const char> is_free) const;
    /// Sum of the squared codes of a direction.
    double explained(std::span<const double> direction) const;
    void subtract(std::span<const double> direction);
    /// The vertex where a direction is longest.
    int longest_vertex(std::span<const double> direction) const;

  private:
    const double* row(std::int64_t i) const { return values_.data() + i * shapes_; }
    std::int64_t row_count() const;
    std::vector<double> vertex_energies() const;
    std::vector<double> project(std::span<const double> direction) const;
    std::vector<double> strongest_channel(int vertex) const;

    std::int64_t shapes_;
    std::vector<int> vertices_;
    std::vector<double> values_;  // (vertices,9,shapes)
};

}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
#include "learning/deflation_residual.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

constexpr int kPowerIterations = 12;
constexpr double kSilent = 1e-5;

double square(double x) { return x * x; }

/// Chunks of vertices, not so many that one partial sum for each takes up much memory.
Chunks chunks_of(std::size_t vertices) {
    constexpr std::int64_t kLeast = 256, kMostChunks = 256;
    const auto count = static_cast<std::int64_t>(vertices);
    return {count, std::max(kLeast, (count + kMostChunks - 1) / kMostChunks)};
}

/// Calls body(first vertex, last vertex) for chunks of vertices.
template <class Body>
void for_chunks(std::size_t vertices, Body&& body) {
    const Chunks chunks = chunks_of(vertices);
    parallel_for(chunks.count(), [&](std::int64_t i) { body(chunks.begin(i), chunks.end(i)); });
}

/// The sum of `size` values over chunks of vertices: body(first, last, sums) adds its part.
template <class Body>
std::vector<double> sum_over_chunks(std::size_t vertices, std::int64_t size, Body&& body) {
    const Chunks chunks = chunks_of(vertices);
    std::vector<double> partials(at(chunks.count() * size), 0.0);
    parallel_for(chunks.count(), [&](std::int64_t i) {
        body(chunks.begin(i), chunks.end(i), partials.data() + i * size);
    });
    std::vector<double> sums(at(size), 0.0);
    for (std::size_t i = 0; i < partials.size(); ++i) sums[i % at(size)] += partials[i];
    return sums;
}

/// Inner products of the nine rows of a vertex with `codes`, side by side: a sum alone would wait
/// for its last addition each time.
std::array<double, kRowDim> products(const double* rows, std::span<const double> codes) {
    std::array<double, kRowDim> sums{};
    for (std::size_t m = 0; m < codes.size(); ++m) {
        for (std::size_t c = 0; c < kRowDim; ++c) sums[c] += rows[c * codes.size() + m] * codes[m];
    }
    return sums;
}

double dot(std::span<const double> a, std::span<const double> b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

}  // namespace

double DeflationDirection::explained() const { return dot(codes, codes); }

DeflationResidual::DeflationResidual(std::int64_t vertices, std::int64_t shapes)
    : shapes_(shapes), vertices_(at(vertices)), values_(at(vertices * kRowDim * shapes)) {
    std::iota(vertices_.begin(), vertices_.end(), 0);
}

template <class T>
void DeflationResidual::fill(const T* rows, std::int64_t lanes, std::int64_t first,
                             std::int64_t count, double (*of)(double), std::int64_t channels) {
    for_chunks(vertices_.size(), [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t i = begin * kRowDim; i < end * kRowDim; ++i) {
            if (i % kRowDim >= channels) continue;
            for (std::int64_t m = 0; m < count; ++m) {
                values_[at(i * shapes_ + first + m)] = of(static_cast<double>(rows[i * lanes + m]));
            }
        }
    });
}

double DeflationResidual::energy_of(std::int64_t place) const {
    const double* rows = row(place * kRowDim);
    double sum = 0;
    for (std::int64_t i = 0; i < kRowDim * shapes_; ++i) sum += square(rows[i]);
    return sum;
}

void DeflationResidual::drop_silent_vertices() {
    energies_.resize(vertices_.size());
    for_chunks(vertices_.size(), [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t n = begin; n < end; ++n) energies_[at(n)] = energy_of(n);
    });
    const double mean = energy() / static_cast<double>(energies_.size());
    std::size_t kept = 0;
    const std::size_t size = at(kRowDim * shapes_);
    for (std::size_t n = 0; n < energies_.size(); ++n) {
        if (energies_[n] < kSilent * mean) continue;
        vertices_[kept] = vertices_[n];
        energies_[kept] = energies_[n];
        if (kept != n)
            std::copy_n(values_.begin() + static_cast<std::ptrdiff_t>(n * size), size,
                        values_.begin() + static_cast<std::ptrdiff_t>(kept * size));
        ++kept;
    }
    vertices_.resize(kept);
    energies_.resize(kept);
    values_.resize(kept * size);
}

double DeflationResidual::energy() const {
    return std::accumulate(energies_.begin(), energies_.end(), 0.0);
}

int DeflationResidual::strongest_vertex() const {
    return vertices_[at(std::max_element(energies_.begin(), energies_.end()) - energies_.begin())];
}

DeflationDirection DeflationResidual::main_direction(int vertex, std::vector<int> places) const {
    // With few shapes their correlations are cheaper than twelve passes over the vertices.
    constexpr std::int64_t kFewShapes = 48;
    const std::vector<double> matrix =
        shapes_ <= kFewShapes ? correlations(places) : std::vector<double>();
    DeflationDirection found{std::move(places), {}, {}};
    found.values.assign(found.places.size() * kRowDim, 0.0);
    std::vector<double> codes = strongest_channel(vertex), next(at(shapes_));
    double length = 0;
    for (int iteration = 0; iteration < kPowerIterations; ++iteration) {
        if (iteration > 0) {
            for (std::size_t m = 0; m < codes.size(); ++m) codes[m] = next[m] / length;
        }
        if (matrix.empty()) {
            next = correlated(found.places, codes);
        } else {
            for (std::size_t m = 0; m < next.size(); ++m) {
                next[m] = dot(std::span(matrix).subspan(m * next.size(), next.size()), codes);
            }
        }
        // |R codes|^2 with R the rows.
        length = std::sqrt(std::max(dot(codes, next), 0.0));
        if (!(length > 0)) {
            found.codes.assign(at(shapes_), 0.0);
            return found;
        }
    }
    for_chunks(found.places.size(), [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t n = begin; n < end; ++n) {
            const auto nine = products(row(found.places[at(n)] * kRowDim), codes);
            for (std::size_t c = 0; c < kRowDim; ++c)
                found.values[at(n) * kRowDim + c] = nine[c] / length;
        }
    });
    for (double& code : next) code /= length;
    found.codes = std::move(next);
    return found;
}

void DeflationResidual::subtract(const DeflationDirection& direction) {
    for_chunks(direction.places.size(), [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t n = begin; n < end; ++n) {
            const std::int64_t place = direction.places[at(n)];
            for (std::int64_t c = 0; c < kRowDim; ++c) {
                const double d = direction.values[at(n * kRowDim + c)];
                double* values = values_.data() + (place * kRowDim + c) * shapes_;
                for (std::int64_t m = 0; m < shapes_; ++m) values[m] -= d * direction.codes[at(m)];
            }
            energies_[at(place)] = energy_of(place);
        }
    });
}

int DeflationResidual::longest_vertex(const DeflationDirection& direction) const {
    std::size_t longest = 0;
    double largest = 0;
    for (std::size_t n = 0; n < direction.places.size(); ++n) {
        double length = 0;
        for (std::size_t c = 0; c < kRowDim; ++c)
            length += square(direction.values[n * kRowDim + c]);
        if (length > largest) {
            largest = length;
            longest = at(direction.places[n]);
        }
    }
    return vertices_[longest];
}

/// Inner products of all pairs of shapes over some vertices, (shapes,shapes).
std::vector<double> DeflationResidual::correlations(std::span<const int> places) const {
    std::vector<double> matrix = sum_over_chunks(
        places.size(), shapes_ * shapes_, [&](std::int64_t begin, std::int64_t end, double* sums) {
            for (std::int64_t n = begin; n < end; ++n) {
                const double* rows = row(places[at(n)] * kRowDim);
                for (std::int64_t m = 0; m < shapes_; ++m) {
                    for (std::int64_t l = 0; l <= m; ++l) {
                        double sum = 0;
                        for (std::int64_t c = 0; c < kRowDim; ++c) {
                            sum += rows[c * shapes_ + m] * rows[c * shapes_ + l];
                        }
                        sums[m * shapes_ + l] += sum;
                    }
                }
            }
        });
    for (std::int64_t m = 0; m < shapes_; ++m) {
        for (std::int64_t l = m + 1; l < shapes_; ++l) {
            matrix[at(m * shapes_ + l)] = matrix[at(l * shapes_ + m)];
        }
    }
    return matrix;
}

/// The same matrix times `codes`, without it.
std::vector<double> DeflationResidual::correlated(std::span<const int> places,
                                                  std::span<const double> codes) const {
    return sum_over_chunks(places.size(), shapes_,
                           [&](std::int64_t begin, std::int64_t end, double* sums) {
                               for (std::int64_t n = begin; n < end; ++n) {
                                   const double* rows = row(places[at(n)] * kRowDim);
                                   const auto nine = products(rows, codes);
                                   for (std::int64_t c = 0; c < kRowDim; ++c) {
                                       for (std::int64_t m = 0; m < shapes_; ++m) {
                                           sums[m] += nine[at(c)] * rows[c * shapes_ + m];
                                       }
                                   }
                               }
                           });
}

/// The channel of `vertex` with the most energy, as codes to start from.
std::vector<double> DeflationResidual::strongest_channel(int vertex) const {
    const auto found = std::lower_bound(vertices_.begin(), vertices_.end(), vertex);
    const std::int64_t first = (found - vertices_.begin()) * kRowDim;
    std::int64_t best = first;
    double largest = -1;
    for (std::int64_t i = first; i < first + kRowDim; ++i) {
        double energy = 0;
        for (std::int64_t m = 0; m < shapes_; ++m) energy += square(row(i)[m]);
        if (energy > largest) {
            largest = energy;
            best = i;
        }
    }
    return {row(best), row(best) + shapes_};
}

template void DeflationResidual::fill(const float*, std::int64_t, std::int64_t, std::int64_t,
                                      double (*)(double), std::int64_t);
template void DeflationResidual::fill(const double*, std::int64_t, std::int64_t, std::int64_t,
                                      double (*)(double), std::int64_t);

}  // namespace mscomp

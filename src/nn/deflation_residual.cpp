// SPDX-License-Identifier: MIT
#include "deflation_residual.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/parallel.h"

namespace mscomp::nn {
namespace {

constexpr std::int64_t kDim = kFeatureDim;
constexpr std::int64_t kChunk = 256;  // vertices
constexpr int kPowerIterations = 12;
constexpr double kSilent = 1e-5;

std::size_t at(std::int64_t index) { return static_cast<std::size_t>(index); }

double square(double x) { return x * x; }

/// body(chunk, first vertex, last vertex) over chunks of vertices.
template <class Body>
std::int64_t for_chunks(std::size_t vertices, Body&& body) {
    const Chunks chunks{static_cast<std::int64_t>(vertices), kChunk};
    parallel_for(chunks.count(), [&](std::int64_t i) { body(i, chunks.begin(i), chunks.end(i)); });
    return chunks.count();
}

std::int64_t chunks_of(std::size_t vertices) {
    return Chunks{static_cast<std::int64_t>(vertices), kChunk}.count();
}

}  // namespace

DeflationResidual::DeflationResidual(std::int64_t vertices, std::int64_t shapes)
    : shapes_(shapes), vertices_(at(vertices)), values_(at(vertices * kDim * shapes)) {
    std::iota(vertices_.begin(), vertices_.end(), 0);
}

std::int64_t DeflationResidual::row_count() const {
    return static_cast<std::int64_t>(vertices_.size()) * kDim;
}

template <class T>
void DeflationResidual::fill(const T* rows, std::int64_t lanes, std::int64_t first,
                             std::int64_t count) {
    for_chunks(vertices_.size(), [&](std::int64_t, std::int64_t begin, std::int64_t end) {
        for (std::int64_t i = begin * kDim; i < end * kDim; ++i) {
            for (std::int64_t m = 0; m < count; ++m) {
                values_[at(i * shapes_ + first + m)] =
                    std::tanh(static_cast<double>(rows[i * lanes + m]));
            }
        }
    });
}

std::vector<double> DeflationResidual::vertex_energies() const {
    std::vector<double> energies(vertices_.size());
    for_chunks(vertices_.size(), [&](std::int64_t, std::int64_t begin, std::int64_t end) {
        for (std::int64_t n = begin; n < end; ++n) {
            double sum = 0;
            for (std::int64_t i = 0; i < kDim * shapes_; ++i) sum += square(row(n * kDim)[i]);
            energies[at(n)] = sum;
        }
    });
    return energies;
}

void DeflationResidual::drop_silent_vertices() {
    const std::vector<double> energies = vertex_energies();
    const double mean = std::accumulate(energies.begin(), energies.end(), 0.0) /
                        static_cast<double>(energies.size());
    std::size_t kept = 0;
    const std::size_t size = at(kDim * shapes_);
    for (std::size_t n = 0; n < energies.size(); ++n) {
        if (energies[n] < kSilent * mean) continue;
        vertices_[kept] = vertices_[n];
        if (kept != n)
            std::copy_n(values_.begin() + static_cast<std::ptrdiff_t>(n * size), size,
                        values_.begin() + static_cast<std::ptrdiff_t>(kept * size));
        ++kept;
    }
    vertices_.resize(kept);
    values_.resize(kept * size);
    values_.shrink_to_fit();
}

double DeflationResidual::energy() const {
    const std::vector<double> energies = vertex_energies();
    return std::accumulate(energies.begin(), energies.end(), 0.0);
}

int DeflationResidual::strongest_vertex() const {
    const std::vector<double> energies = vertex_energies();
    return vertices_[at(std::max_element(energies.begin(), energies.end()) - energies.begin())];
}

std::vector<double> DeflationResidual::main_direction(int vertex,
                                                      std::span<const char> is_free) const {
    std::vector<double> codes = strongest_channel(vertex);
    std::vector<double> direction(at(row_count()), 0.0);
    std::vector<double> squares(at(chunks_of(vertices_.size())));
    for (int iteration = 0; iteration < kPowerIterations; ++iteration) {
        for_chunks(vertices_.size(), [&](std::int64_t chunk, std::int64_t begin, std::int64_t end) {
            double sum = 0;
            for (std::int64_t n = begin; n < end; ++n) {
                if (is_free[at(vertices_[at(n)])] == 0) continue;
                for (std::int64_t i = n * kDim; i < (n + 1) * kDim; ++i) {
                    double projected = 0;
                    for (std::int64_t m = 0; m < shapes_; ++m)
                        projected += row(i)[m] * codes[at(m)];
                    direction[at(i)] = projected;
                    sum += square(projected);
                }
            }
            squares[at(chunk)] = sum;
        });
        const double length = std::accumulate(squares.begin(), squares.end(), 0.0);
        if (!(length > 0)) return std::vector<double>(direction.size(), 0.0);
        for (double& d : direction) d /= std::sqrt(length);
        codes = project(direction);
    }
    return direction;
}

double DeflationResidual::explained(std::span<const double> direction) const {
    double sum = 0;
    for (const double code : project(direction)) sum += square(code);
    return sum;
}

void DeflationResidual::subtract(std::span<const double> direction) {
    const std::vector<double> codes = project(direction);
    for_chunks(vertices_.size(), [&](std::int64_t, std::int64_t begin, std::int64_t end) {
        for (std::int64_t i = begin * kDim; i < end * kDim; ++i) {
            if (direction[at(i)] == 0) continue;
            for (std::int64_t m = 0; m < shapes_; ++m) {
                values_[at(i * shapes_ + m)] -= direction[at(i)] * codes[at(m)];
            }
        }
    });
}

int DeflationResidual::longest_vertex(std::span<const double> direction) const {
    std::size_t longest = 0;
    double largest = -1;
    for (std::size_t n = 0; n < vertices_.size(); ++n) {
        double length = 0;
        for (std::size_t c = 0; c < kDim; ++c) length += square(direction[n * kDim + c]);
        if (length > largest) {
            largest = length;
            longest = n;
        }
    }
    return vertices_[longest];
}

std::vector<double> DeflationResidual::project(std::span<const double> direction) const {
    std::vector<double> partials(at(chunks_of(vertices_.size()) * shapes_), 0.0);
    const std::int64_t chunks =
        for_chunks(vertices_.size(), [&](std::int64_t chunk, std::int64_t begin, std::int64_t end) {
            double* codes = partials.data() + chunk * shapes_;
            for (std::int64_t i = begin * kDim; i < end * kDim; ++i) {
                const double d = direction[at(i)];
                if (d == 0) continue;
                for (std::int64_t m = 0; m < shapes_; ++m) codes[m] += d * row(i)[m];
            }
        });
    std::vector<double> codes(at(shapes_), 0.0);
    for (std::int64_t chunk = 0; chunk < chunks; ++chunk) {
        for (std::int64_t m = 0; m < shapes_; ++m)
            codes[at(m)] += partials[at(chunk * shapes_ + m)];
    }
    return codes;
}

/// The channel of `vertex` with the most energy, as codes to start from.
std::vector<double> DeflationResidual::strongest_channel(int vertex) const {
    const auto found = std::lower_bound(vertices_.begin(), vertices_.end(), vertex);
    const std::int64_t first = (found - vertices_.begin()) * kDim;
    std::int64_t best = first;
    double largest = -1;
    for (std::int64_t i = first; i < first + kDim; ++i) {
        double energy = 0;
        for (std::int64_t m = 0; m < shapes_; ++m) energy += square(row(i)[m]);
        if (energy > largest) {
            largest = energy;
            best = i;
        }
    }
    return {row(best), row(best) + shapes_};
}

template void DeflationResidual::fill(const float*, std::int64_t, std::int64_t, std::int64_t);
template void DeflationResidual::fill(const double*, std::int64_t, std::int64_t, std::int64_t);

}  // namespace mscomp::nn

// SPDX-License-Identifier: MIT
#include "mscomp/nn/start.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/parallel.h"
#include "mscomp/base/random.h"

namespace mscomp::nn {
namespace {

constexpr std::int64_t kDim = kFeatureDim;
constexpr int kPowerIterations = 12;

std::size_t at(std::int64_t index) { return static_cast<std::size_t>(index); }

template <class T>
void set_identity(std::span<T> matrices) {
    for (std::size_t i = 0; i < matrices.size(); ++i) {
        const std::size_t entry = i % (kDim * kDim);
        matrices[i] = entry / kDim == entry % kDim ? T{1} : T{0};
    }
}

/// What is left of the encoder output of one autoencoder, (V,9,n), while components are taken out.
class Residual {
  public:
    Residual(std::int64_t vertices, std::int64_t shapes)
        : vertices_(vertices), shapes_(shapes), values_(at(vertices * kDim * shapes)) {}

    /// Shapes `first` to `first + count - 1`: tanh of the rows (V,9,lanes) of the autoencoder's
    /// input, which is what the encoder gives while its convolution is the identity.
    template <class T>
    void fill(const T* rows, std::int64_t lanes, std::int64_t first, std::int64_t count) {
        for (std::int64_t i = 0; i < vertices_ * kDim; ++i) {
            for (std::int64_t m = 0; m < count; ++m) {
                values_[at(i * shapes_ + first + m)] =
                    std::tanh(static_cast<double>(rows[i * lanes + m]));
            }
        }
    }

    double energy() const {
        double sum = 0;
        for (const double x : values_) sum += square(x);
        return sum;
    }

    /// The vertex with the largest remaining energy.
    std::int64_t strongest_vertex() const {
        std::int64_t best = 0;
        double largest = -1;
        for (std::int64_t v = 0; v < vertices_; ++v) {
            double energy = 0;
            for (std::int64_t i = 0; i < kDim * shapes_; ++i) energy += square(row(v * kDim)[i]);
            if (energy > largest) {
                largest = energy;
                best = v;
            }
        }
        return best;
    }

    /// The unit-length row of component weights that explains most energy among those that vanish
    /// outside `free`, started from the main direction of `vertex`; all zero where nothing is left.
    std::vector<double> main_direction(std::int64_t vertex, const std::vector<char>& free) const {
        std::vector<double> codes = strongest_channel(vertex);
        std::vector<double> direction(at(vertices_ * kDim), 0.0);
        for (int iteration = 0; iteration < kPowerIterations; ++iteration) {
            double length = 0;
            for (std::int64_t i = 0; i < vertices_ * kDim; ++i) {
                if (free[at(i / kDim)] == 0) continue;
                double sum = 0;
                for (std::int64_t m = 0; m < shapes_; ++m) sum += row(i)[m] * codes[at(m)];
                direction[at(i)] = sum;
                length += sum * sum;
            }
            if (!(length > 0)) return std::vector<double>(direction.size(), 0.0);
            for (double& d : direction) d /= std::sqrt(length);
            codes = project(direction);
        }
        return direction;
    }

    /// Sum of the squared codes of `direction`.
    double explained(const std::vector<double>& direction) const {
        double sum = 0;
        for (const double code : project(direction)) sum += square(code);
        return sum;
    }

    void subtract(const std::vector<double>& direction) {
        const std::vector<double> codes = project(direction);
        for (std::int64_t i = 0; i < vertices_ * kDim; ++i) {
            if (direction[at(i)] == 0) continue;
            for (std::int64_t m = 0; m < shapes_; ++m) {
                values_[at(i * shapes_ + m)] -= direction[at(i)] * codes[at(m)];
            }
        }
    }

  private:
    static double square(double x) { return x * x; }
    const double* row(std::int64_t i) const { return values_.data() + i * shapes_; }

    std::vector<double> project(const std::vector<double>& direction) const {
        std::vector<double> codes(at(shapes_), 0.0);
        for (std::int64_t i = 0; i < vertices_ * kDim; ++i) {
            if (direction[at(i)] == 0) continue;
            for (std::int64_t m = 0; m < shapes_; ++m) codes[at(m)] += direction[at(i)] * row(i)[m];
        }
        return codes;
    }

    /// The channel of `vertex` with the most energy, as codes to start from.
    std::vector<double> strongest_channel(std::int64_t vertex) const {
        std::int64_t best = vertex * kDim;
        double largest = -1;
        for (std::int64_t i = vertex * kDim; i < (vertex + 1) * kDim; ++i) {
            double energy = 0;
            for (std::int64_t m = 0; m < shapes_; ++m) energy += square(row(i)[m]);
            if (energy > largest) {
                largest = energy;
                best = i;
            }
        }
        return {row(best), row(best) + shapes_};
    }

    std::int64_t vertices_, shapes_;
    std::vector<double> values_;
};

std::vector<char> free_vertices(const SparsityRow& row) {
    std::vector<char> free;
    for (int v = 0; v < static_cast<int>(row.distances.size()); ++v) {
        free.push_back(row.is_free(v) ? 1 : 0);
    }
    return free;
}

int longest_vertex(const std::vector<double>& direction) {
    int longest = 0;
    double largest = -1;
    for (std::size_t v = 0; v < direction.size() / kDim; ++v) {
        double square = 0;
        for (std::size_t c = 0; c < kDim; ++c) {
            square += direction[v * kDim + c] * direction[v * kDim + c];
        }
        if (square > largest) {
            largest = square;
            longest = static_cast<int>(v);
        }
    }
    return longest;
}

struct FoundComponent {
    int center = 0;
    std::vector<double> direction;  // (V,9)
    double energy = -1;             // explained by it
};

/// A component around the strongest vertex, then around where it is longest, as long as that
/// explains more.
FoundComponent next_component(const Residual& residual, SparsityRows& sparsity) {
    constexpr int kMoves = 6;
    FoundComponent best;
    int center = static_cast<int>(residual.strongest_vertex());
    for (int move = 0; move < kMoves; ++move) {
        FoundComponent found;
        found.center = center;
        found.direction = residual.main_direction(center, free_vertices(sparsity.row(center)));
        found.energy = residual.explained(found.direction);
        if (!(found.energy > best.energy)) break;
        best = std::move(found);
        center = longest_vertex(best.direction);
        if (center == best.center) break;
    }
    return best;
}

/// What the shapes of a start are, and how many fit into one pass.
struct StartShapes {
    const ScaledFeatures& features;
    std::vector<int> shapes;
    std::size_t batch;

    std::span<const int> pass(std::size_t first) const {
        return std::span(shapes).subspan(first, std::min(batch, shapes.size() - first));
    }
};

template <class T>
Residual residual_of(StackedModel<T>& model, int level, std::int64_t a, const StartShapes& start) {
    const std::int64_t vertices = model.vertex_count();
    const std::int64_t lanes = lane_count(model.batch_capacity());
    AlignedVector<T> rows(at(vertices * kDim * lanes));
    Residual residual(vertices, static_cast<std::int64_t>(start.shapes.size()));
    for (std::size_t first = 0; first < start.shapes.size(); first += start.batch) {
        // One pass holds them all: it has been made already.
        if (start.batch < start.shapes.size()) {
            model.load_batch(start.features, start.pass(first));
            model.forward();
        }
        model.input_rows(level, static_cast<int>(a), std::span<T>(rows));
        residual.fill(rows.data(), lanes, static_cast<std::int64_t>(first),
                      static_cast<std::int64_t>(start.pass(first).size()));
    }
    return residual;
}

template <class T>
void deflate_level(StackedModel<T>& model, int index, const StartShapes& start) {
    // Below this part of the first energy there is only rounding left.
    constexpr double kNothingLeft = 1e-10;
    const auto& level = model.levels()[at(index)];
    const std::int64_t vertices = model.vertex_count();
    const std::span<T> weights = model.parameters().value(level.weights);
    std::vector<T> found_weights(weights.size(), T{0});
    std::vector<int> centers;
    for (std::int64_t a = 0; a < level.autoencoders; ++a) {
        Residual residual = residual_of(model, index, a, start);
        const double first_energy = residual.energy();
        for (std::int64_t k = 0; k < level.components; ++k) {
            const FoundComponent found = next_component(residual, *level.sparsity);
            centers.push_back(found.center);
            if (!(found.energy > kNothingLeft * first_energy)) continue;
            residual.subtract(found.direction);
            T* row = found_weights.data() + (a * level.components + k) * vertices * kDim;
            for (std::size_t i = 0; i < found.direction.size(); ++i) {
                row[i] = static_cast<T>(found.direction[i]);
            }
        }
    }
    std::ranges::copy(found_weights, weights.begin());
    level.sparsity->set_centers(std::move(centers));
}

}  // namespace

template <class T>
void start_random(StackedModel<T>& model, std::uint64_t seed) {
    constexpr double kDeviation = 0.02;
    ParameterSet<T>& parameters = model.parameters();
    for (const auto& level : model.levels()) {
        level.sparsity->set_centers({});
        for (const int index : {level.w_own, level.w_ring, level.decoder_w_own,
                                level.decoder_w_ring, level.weights}) {
            const CounterRandom random(seed, static_cast<std::uint64_t>(index) + 1);
            std::vector<T> drawn(parameters.value(index).size());
            for (std::size_t i = 0; i < drawn.size(); ++i) {
                drawn[i] = static_cast<T>(kDeviation * random.normal(i));
            }
            model.from_user_order(index, drawn, parameters.value(index));
        }
        for (const int index : {level.bias, level.decoder_bias}) {
            std::ranges::fill(parameters.value(index), T{0});
        }
    }
}

template <class T>
void start_deflation(StackedModel<T>& model, const ScaledFeatures& features,
                     std::span<const int> shapes) {
    ParameterSet<T>& parameters = model.parameters();
    parameters.reset_values();
    for (const auto& level : model.levels()) {
        set_identity(parameters.value(level.w_own));
        set_identity(parameters.value(level.decoder_w_own));
    }
    constexpr std::size_t kMostShapes = 256;
    const std::size_t count = std::min(shapes.size(), kMostShapes);
    StartShapes start{features, {}, static_cast<std::size_t>(model.batch_capacity())};
    for (std::size_t i = 0; i < count; ++i)
        start.shapes.push_back(shapes[i * shapes.size() / count]);
    model.load_batch(features, start.pass(0));
    for (int level = 0; level < static_cast<int>(model.levels().size()); ++level) {
        model.forward();
        deflate_level(model, level, start);
    }
}

template void start_random(StackedModel<float>&, std::uint64_t);
template void start_random(StackedModel<double>&, std::uint64_t);
template void start_deflation(StackedModel<float>&, const ScaledFeatures&, std::span<const int>);
template void start_deflation(StackedModel<double>&, const ScaledFeatures&, std::span<const int>);

}  // namespace mscomp::nn

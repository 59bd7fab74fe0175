// SPDX-License-Identifier: MIT
#include "units/space_route.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "mscomp/base/index.h"
#include "mscomp/eval/farthest_points.h"
#include "units/quiet_codes.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Changes d of unit length, as c in an orthonormal basis of what shapes span.
struct Turns {
    MatrixXd changes;              // (r,M)
    MatrixXd codes;                // (N,M)
    std::vector<double> loudness;  // (M)
};

/// (3,N) of an edge of a sample.
auto at_edge(const EdgeSample& sample, int place) { return sample.values.middleRows(3 * place, 3); }

/// Directions that leave a part of the length of all shapes, and some more.
int direction_count(const ShapeBasis& basis, double most_left) {
    constexpr int kMore = 6, kMost = 100;
    const auto all = static_cast<int>(basis.sizes.size());
    double left = basis.size * basis.size;
    int count = 0;
    while (count < all && left > most_left * most_left * basis.size * basis.size) {
        left -= basis.sizes[count] * basis.sizes[count];
        ++count;
    }
    return std::min({count + kMore, all, kMost});
}

/// For each seed and each direction in which it turns the quietest change that is 1 there.
Turns quiet_turns(const ShapeBasis& basis, const EdgeSample& sample) {
    constexpr double kNoise = 0.005;
    constexpr double kDead = 1e-10;  // part of the largest square of a seed
    const Index shapes = basis.places.rows(), directions = basis.sizes.size();
    const MatrixXd vectors = basis.places / std::sqrt(static_cast<double>(shapes));
    // Of mean square 1 over the edges of the mesh in each direction.
    const auto places = static_cast<double>(sample.values.rows()) / 3;
    const MatrixXd at_places =
        std::sqrt(places * sample.edges_of_each) *
        (sample.values * (vectors * basis.sizes.cwiseInverse().asDiagonal()));
    const QuietSearch search{at_places, 3,
                             places * (kNoise * basis.size / basis.sizes.array()).square(), 3, 1};
    struct Start {
        int place;
        Vector3d direction;
    };
    std::vector<Start> starts;
    double most = 0, most_there = 0;
    for (const int seed : sample.seeds) {
        most = std::max(most, at_edge(sample, seed).squaredNorm());
        most_there = std::max(most_there, at_places.middleRows(3 * seed, 3).squaredNorm());
    }
    for (const int seed : sample.seeds) {
        const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(
            Matrix3d(at_edge(sample, seed) * at_edge(sample, seed).transpose()));
        for (int a = 2; a >= 0; --a) {
            const Vector3d direction = axes.eigenvectors().col(a);
            const double there =
                (at_places.middleRows(3 * seed, 3).transpose() * direction).squaredNorm();
            if (axes.eigenvalues()[a] > kDead * most && there > kDead * most_there) {
                starts.push_back({seed, direction});
            }
        }
    }
    const auto count = std::ssize(starts);
    MatrixXd here(directions, count);
    for (Index i = 0; i < count; ++i) {
        const Start& start = starts[at(i)];
        here.col(i) = at_places.middleRows(3 * start.place, 3).transpose() * start.direction;
    }
    const std::vector<QuietReadout> found = quiet_readouts(search, here);
    Turns turns{MatrixXd(directions, count), MatrixXd(shapes, count),
                std::vector<double>(starts.size())};
    for (Index i = 0; i < count; ++i) {
        turns.changes.col(i) = found[at(i)].weights.normalized();
        turns.codes.col(i) = vectors * basis.sizes.cwiseProduct(turns.changes.col(i));
        turns.loudness[at(i)] = found[at(i)].loudness;
    }
    return turns;
}

/// Of changes whose codes correlate the quietest, and how many they are; where fewer than three
/// agree, none.
struct Agreed {
    std::vector<int> turns, votes;
};
Agreed quietest_of_each(const Turns& turns) {
    constexpr double kSame = 0.95;
    constexpr int kLeastVotes = 3;
    const MatrixXd alike = correlations(turns.codes, turns.codes);
    std::vector<int> order(turns.loudness.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](int i) { return turns.loudness[at(i)]; });
    std::vector<char> is_left(order.size(), 1);
    Agreed result;
    for (const int i : order) {
        if (is_left[at(i)] == 0) continue;
        int votes = 0;
        for (Index j = 0; j < alike.rows(); ++j) {
            if (is_left[at(j)] == 0 || (!(alike(j, i) >= kSame) && j != i)) continue;
            is_left[at(j)] = 0;
            ++votes;
        }
        if (votes < kLeastVotes) continue;
        result.turns.push_back(i);
        result.votes.push_back(votes);
    }
    return result;
}

/// What of vectors, columns, some of them leave: they are taken one after the other.
class Remainders {
  public:
    explicit Remainders(const MatrixXd& vectors) : left_(vectors) {}
    /// Squares of what is left.
    VectorXd squares() const { return left_.colwise().squaredNorm().transpose(); }
    void take(Index i) {
        const VectorXd own = left_.col(i);
        const double square = own.squaredNorm();
        if (square > 0) left_ -= own * ((own.transpose() * left_) / square).eval();
        left_.col(i).setZero();
    }

  private:
    MatrixXd left_;
};

}  // namespace

std::vector<int> needed_turns(const MatrixXd& codes, const MatrixXd& changes, double all) {
    constexpr double kLeastCode = 0.002, kLeastElsewhere = 0.012;  // of the squares of all shapes
    constexpr double kLeastPlace = 0.3;                            // of the square of the change
    constexpr double kSameCode = 0.9, kSamePlace = 0.5;
    std::vector<int> taken;
    Remainders of_codes(codes), of_changes(changes);
    const MatrixXd alike = correlations(codes, codes), shared = changes.transpose() * changes;
    VectorXd is_free = VectorXd::Ones(codes.cols());
    const auto take = [&](Index i) {
        of_codes.take(i);
        of_changes.take(i);
        is_free[i] = 0;
        for (Index j = 0; j < codes.cols(); ++j) {
            if (alike(i, j) >= kSameCode && std::abs(shared(i, j)) >= kSamePlace) is_free[j] = 0;
        }
        taken.push_back(static_cast<int>(i));
    };
    Index i = 0;
    while (codes.cols() > 0) {
        if (!(is_free.cwiseProduct(of_codes.squares()).maxCoeff(&i) >= kLeastCode * all)) break;
        take(i);
    }
    const VectorXd own = is_free.cwiseProduct(codes.colwise().squaredNorm().transpose());
    while (codes.cols() > 0) {
        const VectorXd left = is_free.cwiseProduct(of_changes.squares());
        const VectorXd strength = (left.array() >= kLeastPlace)
                                      .select(own.cwiseProduct(left), VectorXd::Zero(own.size()));
        if (!(strength.maxCoeff(&i) >= kLeastElsewhere * all)) break;
        take(i);
    }
    return taken;
}

EdgeSample edge_sample(const MetricRows& turns, const std::vector<Point>& middles) {
    constexpr int kPlaces = 1500, kSeeds = 200;
    constexpr double kLeastTurn = 0.05;
    const auto edge_count = static_cast<int>(middles.size());
    std::vector<double> turned;
    for (int e = 0; e < edge_count; ++e) {
        double square = 0;
        for (const float x : turns.vertex(e)) {
            square += static_cast<double>(x) * static_cast<double>(x);
        }
        turned.push_back(std::sqrt(square));
    }
    const double most = turned.empty() ? 0 : *std::ranges::max_element(turned);
    std::vector<int> moving;
    std::vector<Point> middles_of_moving;
    for (int e = 0; e < edge_count; ++e) {
        if (!(turned[at(e)] > kLeastTurn * most)) continue;
        moving.push_back(e);
        middles_of_moving.push_back(middles[at(e)]);
    }
    std::vector<int> seeds = farthest_point_samples(
        middles_of_moving, std::min(kSeeds, static_cast<int>(moving.size())));
    for (int& seed : seeds) seed = moving[at(seed)];
    std::vector<int> edges = farthest_point_samples(middles, std::min(kPlaces, edge_count));
    edges.insert(edges.end(), seeds.begin(), seeds.end());
    std::ranges::sort(edges);
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());

    EdgeSample sample{MatrixXd(3 * std::ssize(edges), turns.shape_count()), {}, 1};
    if (edges.empty()) return sample;
    sample.edges_of_each = static_cast<double>(edge_count) / static_cast<double>(edges.size());
    using Floats = Eigen::Matrix<float, 3, Eigen::Dynamic, Eigen::RowMajor>;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        sample.values.middleRows(static_cast<Index>(3 * i), 3) =
            Eigen::Map<const Floats>(turns.vertex(edges[i]).data(), 3, turns.shape_count())
                .cast<double>();
    }
    for (const int seed : seeds) {
        sample.seeds.push_back(
            static_cast<int>(std::ranges::lower_bound(edges, seed) - edges.begin()));
    }
    return sample;
}

EdgeSample part_of(const EdgeSample& sample, const std::vector<int>& which) {
    return {columns_of(sample.values, which), sample.seeds, sample.edges_of_each};
}

TurningUnits space_route(const MatrixXd& gram, const EdgeSample& sample, double noise) {
    ShapeBasis basis = shape_basis(gram, static_cast<int>(gram.rows()) - 1);
    const int count = direction_count(basis, noise);
    basis.places = basis.places.leftCols(count).eval();
    basis.sizes = basis.sizes.head(count).eval();
    TurningUnits found{{MatrixXd(gram.rows(), 0), {}}, MatrixXd(gram.rows(), 0)};
    if (count == 0 || sample.seeds.empty()) return found;
    const Turns turns = quiet_turns(basis, sample);
    const Agreed agreed = quietest_of_each(turns);
    const MatrixXd codes = columns_of(turns.codes, agreed.turns);
    const MatrixXd changes = columns_of(turns.changes, agreed.turns);
    const std::vector<int> taken = needed_turns(codes, changes, basis.size * basis.size);
    found.units.codes = columns_of(codes, taken);
    // x · d of x = Σ y_n x_n is yᵀ G r, where d = Xᵀ r and X = U S Vᵀ.
    found.readouts = basis.places / std::sqrt(static_cast<double>(gram.rows())) *
                     (basis.sizes.cwiseInverse().asDiagonal() * columns_of(changes, taken));
    for (std::size_t k = 0; k < taken.size(); ++k) {
        const auto column = static_cast<Index>(k);
        Index largest = 0;
        found.units.codes.col(column).cwiseAbs().maxCoeff(&largest);
        const double scale = 1 / found.units.codes(largest, column);
        found.units.codes.col(column) *= scale;
        found.readouts.col(column) *= scale;
        found.units.votes.push_back(agreed.votes[at(taken[k])]);
    }
    return found;
}

}  // namespace mscomp

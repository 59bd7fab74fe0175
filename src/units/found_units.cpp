// SPDX-License-Identifier: MIT
#include "units/found_units.h"

#include <Eigen/QR>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

#include "mscomp/base/index.h"
#include "mscomp/base/random.h"
#include "units/code_route.h"
#include "units/quiet_codes.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double kNoises[] = {0.003, 0.01, 0.02, 0.04, 0.08};
// How many switching units are found again differs much from one subset to another.
constexpr int kSwitchingSubsets = 4, kTurningSubsets = 2;
constexpr int kMostDirections = 60, kSpareShapes = 10;

/// Four fifths of the shapes, drawn by their sizes beside all: the same in any order and unit.
std::vector<int> subset(const MatrixXd& gram, std::uint64_t number) {
    const auto count = at(gram.rows());
    const double all = gram.trace();
    std::vector<std::uint64_t> keys(count);
    for (std::size_t n = 0; n < count; ++n) {
        // Rounded, so that the last bits of a sum decide nothing.
        const double square = gram(static_cast<Index>(n), static_cast<Index>(n));
        const auto part = static_cast<float>(all > 0 ? square / all : 0);
        keys[n] = CounterRandom(std::bit_cast<std::uint32_t>(part), number).bits(0);
    }
    std::vector<int> order(count);
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](int n) { return keys[at(n)]; });
    order.resize((4 * count + 4) / 5);
    std::ranges::sort(order);
    return order;
}

MatrixXd rows_of(const MatrixXd& matrix, const std::vector<int>& which) {
    return columns_of(matrix.transpose(), which).transpose();
}

/// Of a matrix (N,N) the rows and columns `which`.
MatrixXd part_of(const MatrixXd& gram, const std::vector<int>& which) {
    return rows_of(columns_of(gram, which), which);
}

/// Shapes, and what stays the same for every noise.
struct Shapes {
    explicit Shapes(MatrixXd products)
        : gram(std::move(products)),
          basis(shape_basis(
              gram, std::clamp(static_cast<int>(gram.rows()) - kSpareShapes, 1, kMostDirections))) {
    }

    MatrixXd gram;
    ShapeBasis basis;
};

/// Counts in which subsets the units are found again; `search` finds those of a subset.
template <class Search>
void find_again(FoundUnits& found, const std::vector<std::vector<int>>& subsets,
                const Search& search) {
    found.again.assign(at(found.units.count()), 0.0);
    for (std::size_t s = 0; s < subsets.size(); ++s) {
        const std::vector<bool> is_there = found_again(found.units, search(s), subsets[s]);
        for (std::size_t k = 0; k < is_there.size(); ++k) {
            found.again[k] += is_there[k] ? 1.0 / static_cast<double>(subsets.size()) : 0.0;
        }
    }
}

/// Groups of a fifth of the shapes that are near each other, so that a group has no near shapes
/// among the rest: around the largest shape, and around those farthest from all groups before.
std::vector<std::vector<int>> groups_of_like(const MatrixXd& gram) {
    constexpr int kGroups = 3;
    const auto count = static_cast<int>(gram.rows());
    const auto distance = [&](int a, int b) { return gram(a, a) + gram(b, b) - 2 * gram(a, b); };
    std::vector<double> far(at(count));  // from the reference, then from the centres
    for (int n = 0; n < count; ++n) far[at(n)] = gram(n, n);
    std::vector<std::vector<int>> groups;
    for (int g = 0; g < kGroups; ++g) {
        const auto center = static_cast<int>(std::ranges::max_element(far) - far.begin());
        std::vector<int> order(at(count));
        std::iota(order.begin(), order.end(), 0);
        std::ranges::stable_sort(order, {}, [&](int n) { return distance(n, center); });
        order.resize(at((count + 4) / 5));
        std::ranges::sort(order);
        groups.push_back(std::move(order));
        for (int n = 0; n < count; ++n) {
            far[at(n)] = std::min(g == 0 ? distance(n, center) : far[at(n)], distance(n, center));
        }
    }
    return groups;
}

/// Codes (N,K) by least squares of all shapes, of components that have the codes `codes` at the
/// shapes `which`.
MatrixXd read_codes(const MatrixXd& gram, const std::vector<int>& which, const MatrixXd& codes) {
    if (codes.cols() == 0) return MatrixXd(gram.rows(), 0);
    // C = P X of the shapes `which`.
    const MatrixXd by_shapes = codes.completeOrthogonalDecomposition().pseudoInverse();
    const MatrixXd products = by_shapes * columns_of(gram, which).transpose();
    const MatrixXd square = by_shapes * part_of(gram, which) * by_shapes.transpose();
    return square.completeOrthogonalDecomposition().solve(products).transpose();
}

/// Measures codes in groups that `search` does not see: it finds units in the rest and reads their
/// codes in all shapes.
template <class Search>
void hold_out(FoundUnits& found, const MatrixXd& like, const Search& search) {
    const auto count = at(found.units.count());
    std::vector<double> sums(count, 0.0);
    std::vector<int> parts(count, 0);
    for (const std::vector<int>& group : groups_of_like(like)) {
        std::vector<int> rest;
        for (int n = 0; n < static_cast<int>(like.rows()); ++n) {
            if (!std::ranges::binary_search(group, n)) rest.push_back(n);
        }
        const MatrixXd read = search(rest);
        MatrixXd alike = correlations(rows_of(found.units.codes, rest), rows_of(read, rest));
        const MatrixXd there =
            correlations(rows_of(found.units.codes, group), rows_of(read, group));
        const MatrixXd varies = rows_of(found.units.codes, group);
        for (std::size_t k = 0; k < count; ++k) {
            const auto column = static_cast<Index>(k);
            const auto own = varies.col(column).array();
            // A unit that does not act there says nothing of it.
            if ((own - own.mean()).abs().maxCoeff() > 1e-9) ++parts[k];
        }
        Index k = 0, l = 0;
        while (alike.size() > 0 && alike.maxCoeff(&k, &l) > 0) {
            sums[at(k)] += there(k, l);
            alike.row(k).setConstant(-1);
            alike.col(l).setConstant(-1);
        }
    }
    found.held_out.clear();
    for (std::size_t k = 0; k < count; ++k) {
        found.held_out.push_back(parts[k] > 0 ? sums[k] / parts[k] : 0);
    }
}

}  // namespace

double FoundUnits::found_again() const { return std::accumulate(again.begin(), again.end(), 0.0); }

double FoundUnits::median_held_out() const {
    std::vector<double> sorted = held_out;
    std::ranges::sort(sorted);
    return sorted.empty() ? 0 : (sorted[sorted.size() / 2] + sorted[(sorted.size() - 1) / 2]) / 2;
}

double FoundUnits::score() const { return found_again() * (1 - unexplained); }

FoundUnits find_switching_units(const MatrixXd& gram) {
    const Shapes all(gram);
    std::vector<std::vector<int>> subsets;
    std::vector<Shapes> parts;
    for (int s = 0; s < kSwitchingSubsets; ++s) {
        subsets.push_back(subset(gram, static_cast<unsigned>(s)));
        parts.emplace_back(part_of(gram, subsets.back()));
    }
    FoundUnits best;
    for (const double noise : kNoises) {
        FoundUnits found{code_route(gram, all.basis, noise), {}, {}, noise, 1};
        found.unexplained = unexplained(gram, found.units.codes);
        find_again(found, subsets,
                   [&](std::size_t s) { return code_route(parts[s].gram, parts[s].basis, noise); });
        const bool is_better =
            found.score() > best.score() ||
            (found.score() == best.score() && found.units.count() < best.units.count());
        if (noise == kNoises[0] || is_better) best = std::move(found);
    }
    hold_out(best, gram, [&](const std::vector<int>& rest) {
        const Shapes part(part_of(gram, rest));
        const UnitCodes units = code_route(part.gram, part.basis, best.noise);
        return read_codes(gram, rest, units.codes);
    });
    return best;
}

FoundUnits find_turning_units(const MatrixXd& gram, const EdgeSample& sample,
                              const MatrixXd& like) {
    // Noise is taken for movement until what moves is explained.
    constexpr double kTurnNoises[] = {0.1, 0.2, 0.35, 0.5};
    constexpr double kMostUnexplained = 0.05;
    std::vector<std::vector<int>> subsets;
    for (int s = 0; s < kTurningSubsets; ++s) {
        subsets.push_back(subset(like, static_cast<unsigned>(s)));
    }
    FoundUnits best;
    for (const double noise : kTurnNoises) {
        FoundUnits found{space_route(gram, sample, noise).units, {}, {}, noise, 1};
        found.unexplained = unexplained(gram, found.units.codes);
        find_again(found, subsets, [&](std::size_t s) {
            return space_route(part_of(gram, subsets[s]), part_of(sample, subsets[s]), noise).units;
        });
        if (noise == kTurnNoises[0] || found.score() > best.score()) best = std::move(found);
        if (best.unexplained < kMostUnexplained) break;
    }
    hold_out(best, like, [&](const std::vector<int>& rest) {
        const TurningUnits part =
            space_route(part_of(gram, rest), part_of(sample, rest), best.noise);
        return MatrixXd(columns_of(gram, rest) * part.readouts);
    });
    return best;
}

bool are_turning(const FoundUnits& switching, const FoundUnits& turning) {
    constexpr double kMostUnexplained = 1.0 / 3;
    return turning.median_held_out() > switching.median_held_out() &&
           turning.unexplained <= kMostUnexplained;
}

}  // namespace mscomp

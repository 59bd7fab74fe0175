// SPDX-License-Identifier: MIT
#include "units/code_route.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

#include "mscomp/base/index.h"
#include "mscomp/base/random.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double kNoises[] = {0.003, 0.01, 0.02, 0.04, 0.08};
constexpr int kSubsets = 2;
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

MatrixXd part_of(const MatrixXd& gram, const std::vector<int>& which) {
    MatrixXd part(std::ssize(which), std::ssize(which));
    for (std::size_t a = 0; a < which.size(); ++a) {
        for (std::size_t b = 0; b < which.size(); ++b) {
            part(static_cast<Index>(a), static_cast<Index>(b)) = gram(which[a], which[b]);
        }
    }
    return part;
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

}  // namespace

UnitCodes code_route(const MatrixXd& gram, const ShapeBasis& basis, double noise) {
    // Beyond, least squares of codes that are never negative leaves units that are none.
    constexpr double kMostUnexplained = 0.2;
    if (basis.sizes.size() == 0) return {MatrixXd(gram.rows(), 0), {}};
    UnitCodes units = without_predicted(agreed(quiet_codes(basis, noise)));
    if (unexplained(gram, units.codes) > kMostUnexplained) return units;
    return refitted(gram, std::move(units));
}

double FoundUnits::found_again() const { return std::accumulate(again.begin(), again.end(), 0.0); }

double FoundUnits::score() const { return found_again() * (1 - unexplained); }

FoundUnits find_units(const MatrixXd& gram) {
    const Shapes all(gram);
    std::vector<std::vector<int>> subsets;
    std::vector<Shapes> parts;
    for (int s = 0; s < kSubsets; ++s) {
        subsets.push_back(subset(gram, static_cast<unsigned>(s)));
        parts.emplace_back(part_of(gram, subsets.back()));
    }
    FoundUnits best;
    for (const double noise : kNoises) {
        FoundUnits found{code_route(gram, all.basis, noise), {}, noise, 1};
        found.unexplained = unexplained(gram, found.units.codes);
        found.again.assign(at(found.units.count()), 0.0);
        for (std::size_t s = 0; s < parts.size(); ++s) {
            const UnitCodes part = code_route(parts[s].gram, parts[s].basis, noise);
            const std::vector<bool> is_there = found_again(found.units, part, subsets[s]);
            for (std::size_t k = 0; k < is_there.size(); ++k) {
                found.again[k] += is_there[k] ? 1.0 / kSubsets : 0.0;
            }
        }
        const bool is_better =
            found.score() > best.score() ||
            (found.score() == best.score() && found.units.count() < best.units.count());
        if (noise == kNoises[0] || is_better) best = std::move(found);
    }
    return best;
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "units/unit_learner.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <utility>

#include "mscomp/base/error.h"
#include "multiscale/given_balls.h"
#include "units/unit_components.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;

constexpr int kFewestShapes = 12;
// Sets whose units are known are above the first, and below the second, by far.
constexpr double kLeastFoundAgain = 0.5, kMostUnexplained = 0.5;
constexpr double kMostMoving = 0.5;  // part of the vertices, mean of the units

double mean_support(const BallComponents& components) {
    double sum = 0;
    for (const Ball& ball : components.balls()) sum += static_cast<double>(ball.vertices.size());
    return sum / (static_cast<double>(components.count()) * components.vertex_count());
}

}  // namespace

UnitLearner::UnitLearner(UnitModel& model, const UnitSettings& settings, const ShapeSet& shapes,
                         std::span<const int> train)
    : model_(model), settings_(settings), shapes_(shapes), train_(train.begin(), train.end()) {}

MetricRows UnitLearner::rows() const {
    const RowMap& map = model_.map();
    MetricRows rows(shapes_.vertex_count(), static_cast<int>(train_.size()), map.width());
    for (std::size_t m = 0; m < train_.size(); ++m) {
        rows.set(static_cast<int>(m), map.mapped(shapes_, train_[m]));
    }
    return rows;
}

void UnitLearner::start() {
    const MetricRows rows = this->rows();
    begin(rows, gram_of_shapes(rows));
}

/// Shapes as the components of another model say them; units are fitted to the shapes themselves.
void UnitLearner::start_from(const GivenComponents& given) {
    const MetricRows rows = this->rows();
    const BallComponents others = given_balls(given, model_.map());
    const MatrixXd codes = JointCodes(others).solve(products(others, rows));
    begin(rows, codes.transpose() * gram_matrix(others) * codes);
}

void UnitLearner::begin(const MetricRows& rows, const MatrixXd& gram) {
    if (rows.shape_count() < kFewestShapes) {
        throw UsageError(fmt::format("{} training shapes, wanted {} at least to find units in",
                                     rows.shape_count(), kFewestShapes));
    }
    if (!(gram.trace() > 0)) {
        throw UsageError("no training shape differs from the reference: there are no units");
    }
    FoundUnits found = find_units(gram);
    if (found.units.count() == 0) {
        throw UsageError(
            "no two training shapes agree on a unit: they are too few, or each moves in a way of "
            "its own");
    }
    const double part = found.found_again() / found.units.count();
    notes_ = {
        fmt::format("units: {} found at a noise of {}, {:.3g} % of them again in subsets of "
                    "the shapes; their codes explain {:.3g} % of the squares",
                    found.units.count(), found.noise, 100 * part, 100 * (1 - found.unexplained))};
    warnings_.clear();
    if (part < kLeastFoundAgain || found.unexplained > kMostUnexplained) {
        warnings_.push_back(fmt::format(
            "{:.3g} % of {} units are found again in subsets of the shapes, and they explain "
            "{:.3g} % of how these move: too few shapes for the units they have, or units that "
            "hardly ever rest. What is found may be none",
            100 * part, found.units.count(), 100 * (1 - found.unexplained)));
    }
    take(rows, found);
    const double moving = mean_support(model_.components());
    if (moving > kMostMoving) {
        warnings_.push_back(fmt::format(
            "the units move {:.3g} % of the mesh on average: joints, and what else hardly ever "
            "rests, are no units of this sort. What is found may be none",
            100 * moving));
    }
    state_ = {};
}

/// The strongest of what was found, level by level.
void UnitLearner::take(const MetricRows& rows, const FoundUnits& found) {
    std::vector<int> which(at(found.units.count()));
    std::iota(which.begin(), which.end(), 0);
    if (settings_.components > 0 && std::ssize(which) > settings_.components) {
        which = by_movement(unit_components(rows, found.units.codes), found.units.codes);
        which.resize(at(settings_.components));
    }
    const UnitCodes units = chosen(found.units, which);
    const UnitOrder order = order_of_units(unit_components(rows, units.codes), units.codes);
    std::vector<ComponentTrust> trust;
    for (const int k : order.units) {
        trust.push_back({units.votes[at(k)], found.again[at(which[at(k)])]});
    }
    model_.set_units(unit_components(rows, chosen(units, order.units).codes), order.levels,
                     std::move(trust));
}

EpochReport UnitLearner::run_epoch() {
    const auto begin = std::chrono::steady_clock::now();
    const double error = squares_left(rows(), model_.components());
    ++state_.epoch;
    ++state_.step;
    state_.total = error;
    if (state_.first_error == 0) state_.first_error = error;
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - begin;
    return {state_, error, {error}, 0, spent.count(), 1};
}

CodeTable UnitLearner::codes() { return model_.encode(shapes_, train_); }

}  // namespace mscomp

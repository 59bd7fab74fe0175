// SPDX-License-Identifier: MIT
#include "units/unit_learner.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "mscomp/base/error.h"
#include "multiscale/vertex_loops.h"
#include "units/unit_components.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr int kFewestShapes = 4;

}  // namespace

UnitLearner::UnitLearner(UnitModel& model, const UnitSettings& settings, const ShapeSet& shapes,
                         std::span<const int> train)
    : model_(model), settings_(settings), shapes_(shapes), train_(train.begin(), train.end()) {}

MetricRows UnitLearner::rows() const {
    MetricRows rows(shapes_.vertex_count(), static_cast<int>(train_.size()));
    std::vector<float> row(at(shapes_.vertex_count()) * kFeatureDim);
    for (std::size_t m = 0; m < train_.size(); ++m) {
        std::ranges::copy(shapes_.shape(train_[m]), row.begin());
        shapes_.forget(train_[m]);
        model_.scale().scale(row);
        rows.set(static_cast<int>(m), row);
    }
    return rows;
}

void UnitLearner::start() {
    if (std::ssize(train_) < kFewestShapes) {
        throw UsageError(fmt::format(
            "units need shapes that they differ in: {} training shapes, wanted {} at least",
            train_.size(), kFewestShapes));
    }
    const MetricRows rows = this->rows();
    const MatrixXd gram = gram_of_shapes(rows);
    if (!(gram.trace() > 0)) {
        throw UsageError("no training shape differs from the reference: there are no units");
    }
    FoundUnits found = find_units(gram);
    if (found.units.count() == 0) {
        throw UsageError(
            "no two training shapes agree on a unit: they are too few, or each moves in a way of "
            "its "
            "own");
    }
    take(rows, std::move(found));
    state_ = {};
}

/// The strongest of what was found, level by level.
void UnitLearner::take(const MetricRows& rows, FoundUnits found) {
    UnitCodes units = found.units;
    std::vector<double> parts = found.again;
    const auto keep = [&](const std::vector<int>& which) {
        std::vector<double> kept;
        for (const int k : which) kept.push_back(parts[at(k)]);
        units = chosen(units, which);
        parts = std::move(kept);
    };
    if (settings_.components > 0 && units.count() > settings_.components) {
        const BallComponents all = unit_components(rows, units.codes);
        std::vector<int> which = by_movement(all, units.codes);
        which.resize(at(settings_.components));
        keep(which);
    }
    UnitOrder order = order_of_units(unit_components(rows, units.codes), units.codes);
    keep(order.units);
    model_.set_units(unit_components(rows, units.codes), order.levels, {units.votes, parts});
    notes_ = {fmt::format(
        "units: {} found at a noise of {}, {} of them again in random subsets of "
        "the shapes; {:.3g} % of the squares are left",
        found.units.count(), found.noise, found.found_again(), 100 * found.unexplained)};
}

EpochReport UnitLearner::run_epoch() {
    const auto begin = std::chrono::steady_clock::now();
    const MetricRows rows = this->rows();
    const BallComponents& components = model_.components();
    const MatrixXd codes = JointCodes(components).solve(products(components, rows)).transpose();
    const double sum = sum_over_vertices(rows.vertex_count(), [&](int v) {
        ShapesOfVertex left = shapes_at(rows, v);
        const auto acting = components.at_vertex(v);
        const ValuesAtVertex values = values_at(components, v);
        for (std::size_t a = 0; a < acting.size(); ++a) {
            left.noalias() -=
                values.row(static_cast<Index>(a)).transpose() * codes.col(acting[a]).transpose();
        }
        return left.squaredNorm();
    });
    const double error = sum / rows.shape_count();
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

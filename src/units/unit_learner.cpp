// SPDX-License-Identifier: MIT
#include "units/unit_learner.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <optional>
#include <utility>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/interruption.h"
#include "mscomp/base/parallel.h"
#include "multiscale/given_balls.h"
#include "units/unit_components.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;

constexpr int kFewestShapes = 12;
// Sets whose units are known are above the first, and below the second, by far.
constexpr double kLeastFoundAgain = 0.5, kMostUnexplained = 0.5, kLeastHeldOut = 0.5;
constexpr double kMostMoving = 0.5;  // part of the vertices, mean of the units
constexpr double kLeastMoved = 0.2;  // of the greatest length: a vertex that a unit moves

double mean_support(const BallComponents& components) {
    double sum = 0;
    for (const Ball& ball : components.balls()) sum += static_cast<double>(ball.vertices.size());
    return sum / (static_cast<double>(components.count()) * components.vertex_count());
}

ComponentTrust trust_of(const FoundUnits& found, int k) {
    return {found.units.votes[at(k)], found.again[at(k)], std::min(1.0, found.held_out[at(k)])};
}

/// (V,K) squares of the features that units change where their codes in shapes are farthest from 0.
MatrixXd squares_of_units(const FittedTurning& fitted) {
    const auto& [turning, codes] = fitted;
    MatrixXd squares(turning.field().vertex_count(), codes.cols());
    for (Eigen::Index k = 0; k < codes.cols(); ++k) {
        Eigen::Index end = 0;
        codes.col(k).cwiseAbs().maxCoeff(&end);
        std::vector<float> one(at(turning.count()), 0.0F);
        one[at(static_cast<int>(k))] = static_cast<float>(codes(end, k));
        const std::vector<Eigen::Vector3d> rotations = turning.rotations(one);
        const std::vector<float> stretched = turning.stretched(one);
        using Row = Eigen::Matrix<float, kFeatureDim, 1>;
        for (std::size_t v = 0; v < rotations.size(); ++v) {
            const Eigen::Map<const Row> stretch(stretched.data() + v * kFeatureDim);
            squares(static_cast<Eigen::Index>(v), k) =
                rotations[v].squaredNorm() + stretch.cast<double>().squaredNorm();
        }
    }
    return squares;
}

}  // namespace

UnitLearner::UnitLearner(UnitModel& model, const UnitSettings& settings, const ShapeSet& shapes,
                         std::span<const int> train)
    : model_(model), settings_(settings), shapes_(shapes), train_(train.begin(), train.end()) {}

MetricRows UnitLearner::rows() const {
    const RowMap& map = model_.map();
    MetricRows rows(shapes_.vertex_count(), static_cast<int>(train_.size()), map.width());
    parallel_for(std::ssize(train_), [&](std::int64_t m) {
        rows.set(static_cast<int>(m), map.mapped(shapes_, train_[at(m)]));
    });
    return rows;
}

void UnitLearner::start() {
    MetricRows rows = this->rows();
    const MatrixXd gram = gram_of_shapes(rows);
    begin(std::move(rows), gram, {});
}

std::vector<float> UnitLearner::feature(int m) const {
    const std::span<const float> row = shapes_.shape(train_[at(m)]);
    std::vector<float> feature(row.begin(), row.end());
    shapes_.forget(train_[at(m)]);
    return feature;
}

/// Shapes as the components of another model say them; units are fitted to the shapes themselves.
void UnitLearner::start_from(const GivenComponents& given) {
    MetricRows rows = this->rows();
    const BallComponents others = given_balls(given, model_.map());
    const MatrixXd codes = JointCodes(others).solve(products(others, rows));
    begin(std::move(rows), codes.transpose() * gram_matrix(others) * codes, [&](int m) {
        const Eigen::VectorXf own = codes.col(m).cast<float>();
        std::vector<float> row =
            weighted_sum(others, std::span(own.data(), at(static_cast<int>(own.size()))));
        model_.map().unmap(row);
        return row;
    });
}

void UnitLearner::begin(MetricRows rows, const MatrixXd& gram, const Feature& said) {
    if (settings_.route == UnitRoute::space && settings_.rows != ShapeRows::features) {
        throw UsageError("model.route: space looks for turns of features, not of positions");
    }
    if (rows.shape_count() < kFewestShapes) {
        throw UsageError(fmt::format("{} training shapes, wanted {} at least to find units in",
                                     rows.shape_count(), kFewestShapes));
    }
    if (!(gram.trace() > 0)) {
        throw UsageError("no training shape differs from the reference: there are no units");
    }
    const Feature own = [this](int m) { return feature(m); };
    FoundUnits switching, turning;
    std::optional<TurningShapes> shapes;
    if (settings_.route != UnitRoute::space) switching = find_switching_units(gram);
    // Read-outs know nothing of the mesh: that they are of a place is no chance.
    const bool are_local =
        switching.units.count() > 0 &&
        mean_support(unit_components(rows, switching.units.codes)) <= kMostMoving;
    const bool may_turn = settings_.rows == ShapeRows::features &&
                          settings_.route != UnitRoute::codes &&
                          (settings_.route == UnitRoute::space || !are_local);
    if (may_turn) {
        shapes.emplace(model_.mesh(), rows.shape_count(), said ? said : own);
        turning = find_turning_units(
            gram_of_shapes(shapes->turns()),
            edge_sample(shapes->turns(), TurningShapes::middles(model_.mesh(), shapes->field())),
            gram);
    }
    const bool turns =
        may_turn && (settings_.route == UnitRoute::space || switching.units.count() == 0 ||
                     are_turning(switching, turning));
    const FoundUnits& found = turns ? turning : switching;
    if (found.units.count() == 0) {
        throw UsageError(
            "no two training shapes agree on a unit: they are too few, or each moves in a way of "
            "its own");
    }
    note(found, turns ? switching : turning, turns);
    if (turns) {
        if (said) shapes.emplace(model_.mesh(), rows.shape_count(), own);
        take_turning(std::move(rows), *shapes, found);
    } else {
        take_switching(rows, found);
    }
    state_ = {};
}

void UnitLearner::note(const FoundUnits& found, const FoundUnits& other, bool turning) {
    const double part = found.found_again() / found.units.count();
    notes_ = {
        fmt::format(
            "units: {} found, {} at a noise of {}, {:.3g} % of them again in subsets of the "
            "shapes; their codes explain {:.3g} % of the squares",
            found.units.count(), turning ? "of relative rotations" : "of shapes", found.noise,
            100 * part, 100 * (1 - found.unexplained)),
        fmt::format("units: codes in shapes that were left out correlate by {:.2g} with those of "
                    "all (median)",
                    found.median_held_out())};
    if (other.units.count() > 0) {
        notes_.push_back(fmt::format(
            "units: {} {} were found as well; their codes correlate by {:.2g}, and they explain "
            "{:.3g} %",
            other.units.count(), turning ? "of shapes" : "of relative rotations",
            other.median_held_out(), 100 * (1 - other.unexplained)));
    }
    warnings_.clear();
    if (part < kLeastFoundAgain || found.unexplained > kMostUnexplained ||
        (turning && found.median_held_out() < kLeastHeldOut)) {
        warnings_.push_back(fmt::format(
            "{:.3g} % of {} units are found again in subsets of the shapes, their codes correlate "
            "by {:.2g} in shapes left out, and they explain {:.3g} % of how all shapes move: too "
            "few shapes for the units they have, or units that hardly ever rest. What is found may "
            "be none",
            100 * part, found.units.count(), found.median_held_out(),
            100 * (1 - found.unexplained)));
    }
}

/// The strongest units, as many as there may be.
std::vector<int> UnitLearner::strongest(const std::vector<double>& movements) const {
    std::vector<int> which = most_moving_first(movements);
    if (settings_.components > 0 && std::ssize(which) > settings_.components) {
        which.resize(at(settings_.components));
    }
    std::ranges::sort(which);
    return which;
}

void UnitLearner::take_switching(const MetricRows& rows, const FoundUnits& found) {
    const std::vector<int> which =
        strongest(movements(unit_components(rows, found.units.codes), found.units.codes));
    const UnitCodes units = chosen(found.units, which);
    const BallComponents first = unit_components(rows, units.codes);
    std::vector<int> supports;
    for (const Ball& ball : first.balls()) {
        supports.push_back(static_cast<int>(ball.vertices.size()));
    }
    const UnitOrder order = order_of_units(movements(first, units.codes), supports);
    std::vector<ComponentTrust> trust;
    for (const int k : order.units) trust.push_back(trust_of(found, which[at(k)]));
    model_.set_units({unit_components(rows, chosen(units, order.units).codes),
                      order.levels,
                      std::move(trust),
                      {},
                      {}});
    const double moving = mean_support(model_.components());
    if (moving > kMostMoving) {
        warnings_.push_back(fmt::format(
            "the units move {:.3g} % of the mesh on average: joints, and what else hardly ever "
            "rests, are no units of this sort. What is found may be none",
            100 * moving));
    }
}

void UnitLearner::take_turning(MetricRows rows, const TurningShapes& shapes,
                               const FoundUnits& found) {
    // Rotations are integrated; what is left to add up is stretch.
    for (std::size_t i = 0; i < at(rows.vertex_count()) * kFeatureDim; ++i) {
        if (i % kFeatureDim >= kRotationDim) continue;
        for (int m = 0; m < rows.shape_count(); ++m) rows.set(i, m, 0);
    }
    const auto fitted = [&](const std::vector<int>& which) {
        return turning_components(shapes, rows, columns_of(found.units.codes, which),
                                  model_.mesh());
    };
    std::vector<int> which(at(found.units.count()));
    std::iota(which.begin(), which.end(), 0);
    FittedTurning units = fitted(which);
    MatrixXd squares_at = squares_of_units(units);
    if (settings_.components > 0 && std::ssize(which) > settings_.components) {
        const Eigen::RowVectorXd moved = squares_at.colwise().sum();
        which = strongest({moved.begin(), moved.end()});
        units = fitted(which);
        squares_at = squares_of_units(units);
    }
    std::vector<double> moved;
    std::vector<int> supports;
    for (Eigen::Index k = 0; k < squares_at.cols(); ++k) {
        moved.push_back(squares_at.col(k).sum());
        const double least = kLeastMoved * kLeastMoved * squares_at.col(k).maxCoeff();
        supports.push_back(static_cast<int>((squares_at.col(k).array() > least).count()));
    }
    const UnitOrder order = order_of_units(moved, supports);
    std::vector<ComponentTrust> trust;
    std::vector<int> parents;
    for (std::size_t n = 0; n < order.units.size(); ++n) {
        const int k = order.units[n];
        trust.push_back(trust_of(found, which[at(k)]));
        int best = -1;
        double most = 0;
        for (int p = 0; n >= at(order.levels.front()) && p < order.levels.front(); ++p) {
            const double shared = squares_at.col(k).dot(squares_at.col(order.units[at(p)]));
            if (!(shared > most)) continue;
            most = shared;
            best = p;
        }
        parents.push_back(best);
    }
    units.components.choose(order.units);
    const std::vector<Ball> nothing(order.units.size());
    model_.set_units({BallComponents(model_.vertex_count(), nothing), order.levels,
                      std::move(trust), std::move(units.components), std::move(parents)});
}

EpochReport UnitLearner::run_epoch() {
    const auto begin = std::chrono::steady_clock::now();
    const double error =
        model_.is_turning() ? squares_left_by_model() : squares_left(rows(), model_.components());
    ++state_.epoch;
    ++state_.step;
    state_.total = error;
    if (state_.first_error == 0) state_.first_error = error;
    const std::chrono::duration<double, std::milli> spent =
        std::chrono::steady_clock::now() - begin;
    return {state_, error, {error}, 0, spent.count(), 1};
}

/// What decoded codes leave of the squares of a shape, mean over the shapes.
double UnitLearner::squares_left_by_model() {
    double sum = 0;
    for (const int shape : train_) {
        throw_if_interrupted(
            "interrupted while units that were found were measured; go on with --resume");
        const std::vector<int> one{shape};
        std::vector<float> decoded = model_.decode(model_.encode(shapes_, one).values);
        model_.scale().scale(decoded);
        const std::vector<float> row = model_.map().mapped(shapes_, shape);
        for (std::size_t i = 0; i < row.size(); ++i) {
            const double left = static_cast<double>(row[i]) - static_cast<double>(decoded[i]);
            sum += left * left;
        }
    }
    return sum / static_cast<double>(train_.size());
}

CodeTable UnitLearner::codes() { return model_.encode(shapes_, train_); }

}  // namespace mscomp

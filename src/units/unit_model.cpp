// SPDX-License-Identifier: MIT
#include "units/unit_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "mscomp/base/error.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/model/stored_arrays.h"
#include "units/unit_learner.h"

namespace mscomp {
namespace {

constexpr const char* kLevels = "units/levels";      // how many units on each
constexpr const char* kVotes = "units/votes";        // (K)
constexpr const char* kAgain = "units/found_again";  // (K) part of the subsets
constexpr const char* kHeldOut = "units/held_out";   // (K) correlation
constexpr const char* kTurns = "turns";              // components of relative rotations
constexpr const char* kStretches = "stretches";      // of features, twice as many
constexpr const char* kRoots = "turns/roots";        // (P) vertices
constexpr const char* kOfRoots = "turns/of_roots";   // (K,P,3) their rotation vectors

RowMap row_map(const UnitSettings& settings, const ModelPlace& place) {
    return settings.rows == ShapeRows::features ? RowMap(place.scale) : RowMap(place.reference);
}

}  // namespace

UnitModel::UnitModel(const Config& config, const ModelPlace& place)
    : BallModel(place.reference, row_map(config.own<UnitSettings>(), place)),
      settings_(config.own<UnitSettings>()) {
    set_units({BallComponents(vertex_count(), {}, map().width()), {0}, {}, {}, {}});
}

std::vector<LevelSize> UnitModel::levels() const {
    std::vector<LevelSize> sizes;
    for (const int units : levels_) sizes.push_back({1, units});
    return sizes;
}

void UnitModel::set_units(UnitParts parts) {
    set_balls(std::move(parts.components));
    set_parents(std::move(parts.parents));
    levels_ = std::move(parts.levels);
    trust_ = std::move(parts.trust);
    turning_ = std::move(parts.turning);
}

CodeTable UnitModel::encode(const ShapeSet& shapes, std::span<const int> which) {
    if (!turning_) return BallModel::encode(shapes, which);
    CodeTable table{code_count(), {}};
    for (const int shape : which) {
        const Eigen::VectorXf codes = turning_->codes_of(shapes.shape(shape)).cast<float>();
        shapes.forget(shape);
        table.values.insert(table.values.end(), codes.begin(), codes.end());
    }
    return table;
}

std::vector<float> UnitModel::decode(std::span<const float> codes, int levels) const {
    if (!turning_) return BallModel::decode(codes, levels);
    std::vector<float> used(codes.begin(), codes.end());
    std::fill(used.begin() + codes_of_levels(levels), used.end(), 0.0F);
    std::vector<float> row = turning_->stretched(used);
    map().unmap(row);
    const std::vector<Eigen::Vector3d> rotations = turning_->rotations(used);
    for (std::size_t v = 0; v < rotations.size(); ++v) {
        Eigen::Map<Eigen::Vector3f>(row.data() + v * kFeatureDim) = rotations[v].cast<float>();
    }
    return row;
}

std::vector<float> UnitModel::change(std::span<const float> codes,
                                     std::span<const float> from) const {
    if (!turning_) return BallModel::change(codes, from);
    std::vector<float> row = decode(codes);
    const std::vector<float> before = decode(from);
    for (std::size_t i = 0; i < row.size(); ++i) row[i] -= before[i];
    return row;
}

std::vector<CodeColumn> UnitModel::derivatives(std::span<const float> codes) const {
    return turning_ ? turning_->derivatives(codes, map()) : BallModel::derivatives(codes);
}

std::vector<ComponentPlace> UnitModel::places() const {
    return turning_ ? turning_->places() : BallModel::places();
}

std::unique_ptr<Learner> UnitModel::learner(const ShapeSet& shapes, std::span<const int> train) {
    return std::make_unique<UnitLearner>(*this, settings_, shapes, train);
}

void UnitModel::save(StoredArrays& arrays) const {
    save_balls(arrays);
    arrays.keep<int>(kLevels, {std::ssize(levels_)}, levels_);
    std::vector<int> votes;
    std::vector<double> again, held_out;
    for (const ComponentTrust& trust : trust_) {
        votes.push_back(trust.votes);
        again.push_back(trust.found_again);
        held_out.push_back(trust.held_out);
    }
    arrays.keep<int>(kVotes, {code_count()}, std::move(votes));
    arrays.keep<double>(kAgain, {code_count()}, std::move(again));
    arrays.keep<double>(kHeldOut, {code_count()}, std::move(held_out));
    if (!turning_) return;
    keep_components(kTurns, turning_->turns(), arrays);
    keep_components(kStretches, turning_->stretches(), arrays);
    const std::vector<int>& roots = turning_->field().roots();
    arrays.keep<int>(kRoots, {std::ssize(roots)}, roots);
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> of_roots =
        turning_->roots();
    arrays.keep<double>(kOfRoots, {turning_->count(), std::ssize(roots), kRotationDim},
                        {of_roots.data(), of_roots.data() + of_roots.size()});
}

/// Of `count` units; none for a file without.
std::optional<TurningComponents> UnitModel::load_turning(const SafetensorsFile& file,
                                                         int count) const {
    if (!file.contains(kRoots)) return {};
    const auto roots = file.data<int>(kRoots, {-1});
    try {
        TurnField field(reference(), {roots.begin(), roots.end()});
        BallComponents turns = stored_components(file, kTurns, field.edge_count(), kRotationDim);
        BallComponents stretches = stored_components(file, kStretches, vertex_count(), kFeatureDim);
        const bool fits = map().rows() == ShapeRows::features && turns.count() == count &&
                          stretches.count() == 2 * count && field.roots().size() == roots.size();
        if (!fits) {
            throw CheckpointError(
                file.path(),
                fmt::format(
                    "{} turning units, {} stretches, {} roots; wanted {}, {}, {} and features",
                    turns.count(), stretches.count(), roots.size(), count, 2 * count,
                    field.roots().size()));
        }
        const auto of_roots = file.data<double>(kOfRoots, {count, std::ssize(roots), kRotationDim});
        Eigen::MatrixXd values(count, kRotationDim * std::ssize(roots));
        for (Eigen::Index i = 0; i < values.size(); ++i) {
            values(i / values.cols(), i % values.cols()) = of_roots[at(i)];
        }
        return TurningComponents(std::move(field), std::move(turns), std::move(values),
                                 std::move(stretches));
    } catch (const UsageError& error) {
        throw CheckpointError(file.path(), error.what());
    }
}

void UnitModel::load(const SafetensorsFile& file) {
    BallComponents components = load_balls(file);
    const int most = settings_.components > 0 ? settings_.components : kMostUnits;
    if (components.count() > most) {
        throw CheckpointError(file.path(),
                              fmt::format("{} units, wanted {} at most", components.count(), most));
    }
    const auto levels = file.data<int>(kLevels, {-1});
    const auto votes = file.data<int>(kVotes, {components.count()});
    const auto again = file.data<double>(kAgain, {components.count()});
    const auto held_out = file.data<double>(kHeldOut, {components.count()});
    const bool has_levels = !levels.empty() && levels.size() <= 2 &&
                            std::ranges::all_of(levels, [](int units) { return units > 0; });
    const auto sum = std::accumulate(levels.begin(), levels.end(), std::int64_t{0});
    if (!has_levels || sum != components.count()) {
        throw CheckpointError(file.path(),
                              fmt::format("{} units on {} levels, wanted {} on one or two", sum,
                                          levels.size(), components.count()));
    }
    const auto is_part = [](double part) { return part >= 0 && part <= 1; };
    const bool is_sound = std::ranges::all_of(votes, [](int n) { return n >= 0; }) &&
                          std::ranges::all_of(again, is_part) &&
                          std::ranges::all_of(held_out, is_part);
    if (!is_sound) throw CheckpointError(file.path(), "votes or parts of subsets that none can be");
    std::vector<ComponentTrust> trust;
    for (std::size_t k = 0; k < votes.size(); ++k) {
        trust.push_back({votes[k], again[k], held_out[k]});
    }
    std::optional<TurningComponents> turning = load_turning(file, components.count());
    set_units({std::move(components),
               {levels.begin(), levels.end()},
               std::move(trust),
               std::move(turning),
               {}});
    set_parents(load_parents(file));
}

}  // namespace mscomp

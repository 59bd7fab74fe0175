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

RowMap row_map(const UnitSettings& settings, const ModelPlace& place) {
    return settings.rows == ShapeRows::features ? RowMap(place.scale) : RowMap(place.reference);
}

}  // namespace

UnitModel::UnitModel(const Config& config, const ModelPlace& place)
    : BallModel(place.reference, row_map(config.own<UnitSettings>(), place)),
      settings_(config.own<UnitSettings>()) {
    set_units(BallComponents(vertex_count(), {}, map().width()), {0}, {});
}

std::vector<LevelSize> UnitModel::levels() const {
    std::vector<LevelSize> sizes;
    for (const int units : levels_) sizes.push_back({1, units});
    return sizes;
}

void UnitModel::set_units(BallComponents components, std::vector<int> levels,
                          std::vector<ComponentTrust> trust) {
    set_balls(std::move(components));
    levels_ = std::move(levels);
    trust_ = std::move(trust);
}

std::unique_ptr<Learner> UnitModel::learner(const ShapeSet& shapes, std::span<const int> train) {
    return std::make_unique<UnitLearner>(*this, settings_, shapes, train);
}

void UnitModel::save(StoredArrays& arrays) const {
    save_balls(arrays);
    arrays.keep<int>(kLevels, {std::ssize(levels_)}, levels_);
    std::vector<int> votes;
    std::vector<double> again;
    for (const ComponentTrust& trust : trust_) {
        votes.push_back(trust.votes);
        again.push_back(trust.found_again);
    }
    arrays.keep<int>(kVotes, {code_count()}, std::move(votes));
    arrays.keep<double>(kAgain, {code_count()}, std::move(again));
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
    const bool has_levels = !levels.empty() && levels.size() <= 2 &&
                            std::ranges::all_of(levels, [](int units) { return units > 0; });
    const auto sum = std::accumulate(levels.begin(), levels.end(), std::int64_t{0});
    if (!has_levels || sum != components.count()) {
        throw CheckpointError(file.path(),
                              fmt::format("{} units on {} levels, wanted {} on one or two", sum,
                                          levels.size(), components.count()));
    }
    const bool is_sound =
        std::ranges::all_of(votes, [](int n) { return n >= 0; }) &&
        std::ranges::all_of(again, [](double part) { return part >= 0 && part <= 1; });
    if (!is_sound) throw CheckpointError(file.path(), "votes or parts of subsets that none can be");
    std::vector<ComponentTrust> trust;
    for (std::size_t k = 0; k < votes.size(); ++k) trust.push_back({votes[k], again[k]});
    set_units(std::move(components), {levels.begin(), levels.end()}, std::move(trust));
}

}  // namespace mscomp

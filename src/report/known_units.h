// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mscomp/eval/unit_matches.h"
#include "mscomp/model/components.h"

namespace mscomp {

/// True weights of the shapes of a set (expressions of a face, joint angles of a hand): a CSV file,
/// one row per shape, one column per unit, perhaps with a first line of names.
class KnownUnits {
  public:
    /// For a set of `shape_count` shapes: as many rows, or one less, which then belong to the
    /// shapes after the first (the reference, whose weights are 0). Throws IoError, or InputError
    /// with the line: not numbers, rows of different length, another number of rows.
    KnownUnits(const std::string& path, int shape_count);

    /// Weights (N,U) that are there already.
    KnownUnits(std::vector<std::string> names, std::vector<double> weights)
        : names_(std::move(names)), weights_(std::move(weights)) {}

    int unit_count() const { return static_cast<int>(names_.size()); }
    /// Names of the units, their column counted from 0 where the file has none.
    const std::vector<std::string>& names() const { return names_; }
    /// (U) of one shape.
    std::span<const double> of_shape(int shape) const;

    /// Units whose weights are not the same for all of `shapes`: only they can be matched.
    int varying_count(std::span<const int> shapes) const;
    /// |correlation| from which on a unit counts as matched.
    static constexpr double kThreshold = 0.9;
    /// How well the codes (n,K) of n `shapes` tell the units.
    UnitMatches correlations(std::span<const int> shapes, std::span<const double> codes) const;
    /// Which units they tell: "matched", "matched_one_to_one" and a "list"
    /// with the best component of each unit (eval/unit_matches.h). A code belongs to the component
    /// of the same index.
    nlohmann::ordered_json matches(const UnitMatches& found,
                                   const std::vector<Component>& components) const;
    nlohmann::ordered_json matches(std::span<const int> shapes, std::span<const double> codes,
                                   const std::vector<Component>& components) const {
        return matches(correlations(shapes, codes), components);
    }

  private:
    std::vector<std::string> names_;  // (U)
    std::vector<double> weights_;     // (N,U)
};

}  // namespace mscomp

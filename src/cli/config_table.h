// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "mscomp/nn/config.h"

namespace mscomp {

/// What a number may be, ends included unless `low_open`.
struct Bounds {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool low_open = false;

    bool contain(double value) const {
        return (low_open ? value > low : value >= low) && value <= high;
    }
};

/// A field that holds one of a few names.
struct Choice {
    std::vector<std::string> names;
    std::function<std::size_t()> get;
    std::function<void(std::size_t)> set;
};

struct Key;
using Table = std::vector<Key>;

/// Where the value of a key lives; a Table is a section with keys of its own.
using Field =
    std::variant<bool*, int*, std::uint64_t*, double*, std::string*, Choice, std::optional<double>*,
                 std::optional<nn::SparsityRamp>*, std::vector<nn::LevelConfig>*, Table>;

/// One key of the configuration: the single place that knows its name, field, range and meaning.
struct Key {
    std::string name;
    Field field;
    Bounds bounds;
    std::string comment;
    bool required = false;  // in every new entry of the list it stands in
};

/// Every key that a configuration of config.kind has, bound to the fields of `config`, which must
/// outlive the table and keep its kind.
Table config_table(nn::Config& config);
/// The keys of one entry of model.levels.
Table level_table(nn::LevelConfig& level);

/// What a key may be, for messages and comments: "a whole number >= 1".
std::string wanted(const Key& key);

}  // namespace mscomp

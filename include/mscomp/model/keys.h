// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

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

inline constexpr Bounds kUnitRange{0, 1};
inline constexpr Bounds kNotNegative{0};
inline constexpr Bounds kAtLeastOne{1};
inline constexpr Bounds kPositive{.low = 0, .low_open = true};
inline constexpr Bounds kPositiveUpToOne{.low = 0, .high = 1, .low_open = true};

/// A field that holds one of a few names.
struct Choice {
    std::vector<std::string> names;
    std::function<std::size_t()> get;
    std::function<void(std::size_t)> set;
};

/// An interval [from, to] within [0, 1], or nothing.
struct IntervalField {
    using Interval = std::optional<std::pair<double, double>>;
    std::function<Interval()> get;
    std::function<void(const Interval&)> set;
};

struct Key;
using Table = std::vector<Key>;

/// A list of at least one entry, each a section with the same keys.
struct List {
    std::string entries;  // what one is, for messages: "level"
    std::function<std::size_t()> size;
    std::function<void(std::size_t)> replace;  // all by so many with defaults
    std::function<Table(std::size_t)> entry;   // bound to an entry that there is
    std::function<Table()> sample;             // bound to nothing: for names only
};

/// Where the value of a key lives; a Table is a section with keys of its own.
using Field = std::variant<bool*, int*, std::uint64_t*, double*, std::string*, Choice,
                           std::optional<double>*, IntervalField, List, Table>;

/// One key of the configuration: the single place that knows its name, field, range and meaning.
struct Key {
    std::string name;
    Field field;
    Bounds bounds;
    std::string comment;
    bool required = false;  // in every new entry of the list it stands in
};

/// A choice bound to an enum.
template <class Enum>
Choice choice(Enum& value, std::vector<std::pair<Enum, std::string>> values) {
    Choice result;
    for (const auto& [each, name] : values) result.names.push_back(name);
    result.get = [&value, values] {
        const auto found = std::find_if(values.begin(), values.end(),
                                        [&value](const auto& v) { return v.first == value; });
        return static_cast<std::size_t>(found - values.begin());
    };
    result.set = [&value, values](std::size_t index) { value = values[index].first; };
    return result;
}

/// Adds the keys `more` behind those of `table`.
void append(Table& table, Table more);

/// What a key may be, for messages and comments: "a whole number >= 1".
std::string wanted(const Key& key);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/model/keys.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <string_view>

namespace mscomp {
namespace {

std::string listed(const std::vector<std::string>& names) {
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (i > 0) text += i + 1 == names.size() ? " or " : ", ";
        text += names[i];
    }
    return text;
}

std::string within(const std::string& kind, const Bounds& bounds) {
    if (std::isinf(bounds.low)) return kind;
    const std::string_view sign = bounds.low_open ? ">" : ">=";
    if (std::isinf(bounds.high)) return fmt::format("{} {} {}", kind, sign, bounds.low);
    return fmt::format("{} {} {} and <= {}", kind, sign, bounds.low, bounds.high);
}

std::string joined_names(const Table& table, bool required_only) {
    std::string text;
    for (const Key& key : table) {
        if (required_only && !key.required) continue;
        text += (text.empty() ? "" : ", ") + key.name;
    }
    return text;
}

struct Wanted {
    const Bounds& bounds;
    std::string operator()(const bool*) const { return "true or false"; }
    std::string operator()(const int*) const { return within("a whole number", bounds); }
    std::string operator()(const std::uint64_t*) const { return within("a whole number", bounds); }
    std::string operator()(const double*) const { return within("a number", bounds); }
    std::string operator()(const std::string*) const { return "a file name"; }
    std::string operator()(const Choice& field) const { return listed(field.names); }
    std::string operator()(const std::optional<double>*) const {
        return within("a number", bounds) + ", or null";
    }
    std::string operator()(const IntervalField&) const {
        return "[from, to] with 0 <= from < to <= 1, or null";
    }
    std::string operator()(const List& list) const {
        return fmt::format("a list of at least one {} {{{}}}", list.entries,
                           joined_names(list.sample(), true));
    }
    std::string operator()(const Table& table) const {
        return fmt::format("a mapping with the keys {}", joined_names(table, false));
    }
};

}  // namespace

void append(Table& table, Table more) { std::ranges::move(more, std::back_inserter(table)); }

std::string wanted(const Key& key) { return std::visit(Wanted{key.bounds}, key.field); }

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "config_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "mscomp/base/index.h"
#include "mscomp/base/parsed_number.h"
#include "mscomp/base/printable.h"

namespace mscomp {
namespace {

// yaml-cpp marks quoted scalars with the tag "!": they are text, whatever they look like.
bool is_plain(const YAML::Node& node) { return node.IsScalar() && node.Tag() != "!"; }

template <class Number>
std::optional<Number> parse_number(const YAML::Node& node) {
    if (!is_plain(node)) return {};
    return parsed_number<Number>(node.Scalar());
}

struct ReadValue {
    const YAML::Node& node;
    const Bounds& bounds;

    bool operator()(bool* field) const {
        if (!is_plain(node)) return false;
        if (node.Scalar() != "true" && node.Scalar() != "false") return false;
        *field = node.Scalar() == "true";
        return true;
    }
    bool operator()(int* field) const { return read_number(field); }
    bool operator()(std::uint64_t* field) const { return read_number(field); }
    bool operator()(double* field) const { return read_number(field); }
    bool operator()(std::string* field) const {
        if (!node.IsScalar()) return false;
        *field = node.Scalar();
        return true;
    }
    bool operator()(const Choice& field) const {
        if (!node.IsScalar()) return false;
        const auto name = std::find(field.names.begin(), field.names.end(), node.Scalar());
        if (name == field.names.end()) return false;
        field.set(at(name - field.names.begin()));
        return true;
    }
    bool operator()(std::optional<double>* field) const {
        if (node.IsNull()) {
            field->reset();
            return true;
        }
        double value = 0;
        if (!read_number(&value)) return false;
        *field = value;
        return true;
    }
    bool operator()(const IntervalField& field) const {
        if (node.IsNull()) {
            field.set(std::nullopt);
            return true;
        }
        if (!node.IsSequence() || node.size() != 2) return false;
        const auto from = parse_number<double>(node[0]);
        const auto to = parse_number<double>(node[1]);
        if (!from || !to || !(*from >= 0 && *from < *to && *to <= 1)) return false;
        field.set(std::pair{*from, *to});
        return true;
    }
    bool operator()(const List&) const { return false; }
    bool operator()(const Table&) const { return false; }

    template <class Number>
    bool read_number(Number* field) const {
        const std::optional<Number> value = parse_number<Number>(node);
        if (!value || !std::isfinite(static_cast<double>(*value))) return false;
        if (!bounds.contain(static_cast<double>(*value))) return false;
        *field = *value;
        return true;
    }
};

}  // namespace

FilePosition position_of(const YAML::Node& node, const std::string& path) {
    const YAML::Mark mark = node.Mark();
    return mark.is_null() ? FilePosition{path, 0, 0}
                          : FilePosition{path, mark.line + 1, mark.column + 1};
}

bool read_value(const Key& key, const YAML::Node& node) {
    return std::visit(ReadValue{node, key.bounds}, key.field);
}

std::string found(const YAML::Node& node) {
    if (node.IsMap()) return "a mapping";
    if (node.IsSequence()) return "a list";
    if (!node.IsScalar()) return "nothing";
    constexpr std::size_t kLongest = 80;
    const std::string& text = node.Scalar();
    const bool is_short = text.size() <= kLongest;
    return fmt::format("\"{}{}\"", whole_characters(text, kLongest), is_short ? "" : "...");
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "known_units.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string_view>

#include "mscomp/base/error.h"
#include "mscomp/base/file_kind.h"
#include "mscomp/base/index.h"

namespace mscomp {
namespace {

std::string_view trimmed(std::string_view text) {
    const char* const blanks = " \t\r\"";
    const std::size_t first = text.find_first_not_of(blanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::vector<std::string_view> cells_of(std::string_view line) {
    std::vector<std::string_view> cells;
    for (std::size_t begin = 0;;) {
        const std::size_t end = line.find(',', begin);
        cells.push_back(trimmed(line.substr(begin, end - begin)));
        if (end == std::string_view::npos) return cells;
        begin = end + 1;
    }
}

std::optional<double> number_in(std::string_view cell) {
    double value = 0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc{} || end != cell.data() + cell.size() || !std::isfinite(value))
        return {};
    return value;
}

}  // namespace

KnownUnits::KnownUnits(const std::string& path, int shape_count) {
    std::istringstream lines(read_text_file(path, "a table of weights"));
    std::string line;
    int rows = 0;
    for (std::int64_t number = 1; std::getline(lines, line); ++number) {
        if (trimmed(line).empty()) continue;
        const std::vector<std::string_view> cells = cells_of(line);
        if (names_.empty()) {
            const bool has_names = !number_in(cells.front());
            for (std::size_t c = 0; c < cells.size(); ++c) {
                names_.push_back(has_names ? std::string(cells[c]) : fmt::format("{}", c));
            }
            if (has_names) continue;
        }
        if (cells.size() != names_.size()) {
            throw InputError({path, number},
                             fmt::format("{} weights, wanted {}", cells.size(), names_.size()));
        }
        for (const std::string_view cell : cells) {
            const std::optional<double> value = number_in(cell);
            if (!value) {
                throw InputError({path, number}, fmt::format("got \"{}\", wanted a number", cell));
            }
            weights_.push_back(*value);
        }
        ++rows;
    }
    if (rows != shape_count && rows != shape_count - 1) {
        throw InputError({path}, fmt::format("{} rows of weights, wanted {}, one per shape, or {} "
                                             "without the first shape",
                                             rows, shape_count, shape_count - 1));
    }
    if (rows < shape_count) weights_.insert(weights_.begin(), names_.size(), 0.0);
}

std::span<const double> KnownUnits::of_shape(int shape) const {
    return std::span<const double>(weights_).subspan(at(shape) * names_.size(), names_.size());
}

int KnownUnits::varying_count(std::span<const int> shapes) const {
    int count = 0;
    for (std::size_t u = 0; u < names_.size(); ++u) {
        const auto differs = [&](int shape) {
            return of_shape(shape)[u] != of_shape(shapes.front())[u];
        };
        if (std::ranges::any_of(shapes, differs)) ++count;
    }
    return count;
}

UnitMatches KnownUnits::correlations(std::span<const int> shapes,
                                     std::span<const double> codes) const {
    std::vector<double> weights;
    for (const int shape : shapes) {
        const std::span<const double> row = of_shape(shape);
        weights.insert(weights.end(), row.begin(), row.end());
    }
    return correlation_table(codes, weights, static_cast<int>(shapes.size()), kThreshold);
}

nlohmann::ordered_json KnownUnits::matches(const UnitMatches& found,
                                           const std::vector<Component>& components) const {
    const auto described = [&](const UnitMatch& match) {
        nlohmann::ordered_json id = nullptr;
        if (match.code >= 0) id = components[at(match.code)].id;
        return nlohmann::ordered_json{{"component", id}, {"correlation", match.correlation}};
    };
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (std::size_t u = 0; u < found.best.size(); ++u) {
        list.push_back({{"unit", names_[u]},
                        {"best", described(found.best[u])},
                        {"one_to_one", described(found.one_to_one[u])}});
    }
    return {{"matched", found.matched},
            {"matched_one_to_one", found.matched_one_to_one},
            {"list", list}};
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/base/nearest_name.h"

#include <algorithm>
#include <numeric>

namespace mscomp {

std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i + 1;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

std::string nearest_name(std::string_view name, const std::vector<std::string>& names) {
    // What is longer than any name is not misspelt, and may be very long.
    constexpr std::size_t kLongest = 256;
    name = name.substr(0, kLongest);
    const auto nearest = std::min_element(
        names.begin(), names.end(), [name](const std::string& a, const std::string& b) {
            return edit_distance(name, a) < edit_distance(name, b);
        });
    return nearest == names.end() ? std::string{} : *nearest;
}

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/acap/mesh/natural_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <compare>
#include <filesystem>
#include <numeric>

#include "name_numbers.h"

namespace mscomp {
namespace {

/// A path as it is compared: its folders and its stem, each in pieces, then the rest as it is.
struct PathKey {
    std::vector<NamePieces> parts;
    std::string extension;
    std::string path;
};

std::vector<std::string> parts_of(const std::string& path) {
    const std::filesystem::path whole(path);
    std::vector<std::string> parts;
    for (const auto& folder : whole.parent_path()) parts.push_back(folder.string());
    parts.push_back(whole.stem().string());
    return parts;
}

PathKey key_of(const std::string& path, const NumberReading& reading) {
    PathKey key;
    for (const std::string& part : parts_of(path)) key.parts.push_back(pieces_of(part, reading));
    key.extension = std::filesystem::path(path).extension().string();
    key.path = path;
    return key;
}

std::strong_ordering compare(const PathKey& a, const PathKey& b) {
    for (std::size_t i = 0; i < std::min(a.parts.size(), b.parts.size()); ++i) {
        const auto order = compare_pieces(a.parts[i], b.parts[i]);
        if (std::is_neq(order)) return order;
    }
    if (a.parts.size() != b.parts.size()) return a.parts.size() <=> b.parts.size();
    if (a.extension != b.extension) return a.extension <=> b.extension;
    return a.path <=> b.path;
}

/// Numbers of the paths in their order.
std::vector<std::size_t> order_of(const std::vector<std::string>& paths,
                                  const NumberReading& reading) {
    std::vector<PathKey> keys;
    for (const std::string& path : paths) keys.push_back(key_of(path, reading));
    std::vector<std::size_t> order(paths.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
        return std::is_lt(compare(keys[i], keys[j]));
    });
    return order;
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) {
    const auto order = compare_pieces(pieces_of(a, {}), pieces_of(b, {}));
    return std::is_neq(order) ? std::is_lt(order) : a < b;
}

NaturalOrder::NaturalOrder(const std::vector<std::string>& paths) {
    NumberEvidence evidence;
    for (const std::string& path : paths) {
        for (const std::string& part : parts_of(path)) evidence.add(part);
    }
    reading_ = evidence.reading();
    if (!evidence.is_in_doubt()) return;
    NumberReading other = reading_;
    other.decimals = !other.decimals;
    const std::vector<std::size_t> used = order_of(paths, reading_), rest = order_of(paths, other);
    const auto differs = std::mismatch(used.begin(), used.end(), rest.begin());
    if (differs.first == used.end()) return;
    doubt_ = fmt::format(
        "the order of the shapes is in doubt: numbers with a point are read as two counters, so "
        "that {} comes before {}; if they are fractions, name the files in order with --list",
        paths[*differs.first], paths[*differs.second]);
}

void NaturalOrder::sort(std::vector<std::string>& paths) const {
    std::vector<std::string> sorted;
    for (const std::size_t i : order_of(paths, reading_)) sorted.push_back(paths[i]);
    paths = std::move(sorted);
}

bool NaturalOrder::less(const std::string& a, const std::string& b) const {
    return std::is_lt(compare(key_of(a, reading_), key_of(b, reading_)));
}

}  // namespace mscomp

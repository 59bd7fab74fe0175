// SPDX-License-Identifier: MIT
#include "npz_arrays.h"

#include <fmt/format.h>

#include <utility>

#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

std::string lower(std::string text) {
    for (char& c : text) c = 'A' <= c && c <= 'Z' ? static_cast<char>(c + 32) : c;
    return text;
}

}  // namespace

NpzArrays::NpzArrays(const std::string& path)
    : path_(path), file_(std::make_unique<const std::string>(read_file(path))) {
    const auto bytes = std::as_bytes(std::span<const char>(file_->data(), file_->size()));
    for (ZipEntry& entry : read_zip_entries(bytes, path)) {
        std::string name = entry.name;
        if (name.ends_with(".npy")) name.resize(name.size() - 4);
        left_.insert(name);
        entries_.emplace(std::move(name), std::move(entry));
    }
}

std::string NpzArrays::place_of(const std::string& name) const {
    return fmt::format("{}[{}]", path_, name);
}

OwnedArray NpzArrays::load(const std::string& name) {
    left_.erase(name);
    return unpacked(name);
}

std::optional<std::string> NpzArrays::name_among(std::span<const std::string_view> names,
                                                 bool (*looks_like_it)(const NpyArray&),
                                                 std::vector<std::string>& notes) const {
    std::vector<std::string> found;
    for (const std::string_view name : names) {
        for (const auto& [own, entry] : entries_) {
            if (lower(own) == name) found.push_back(own);
        }
    }
    if (found.size() > 1) {
        throw InputError({path_}, fmt::format("holds both '{}' and '{}', wanted one of them",
                                              found[0], found[1]));
    }
    if (!found.empty()) return found.front();
    for (const auto& [own, entry] : entries_) {
        const std::optional<OwnedArray> array = peek(own);
        if (array && looks_like_it(array->array)) found.push_back(own);
    }
    if (found.size() != 1) return std::nullopt;
    notes.push_back(fmt::format("'{}' is taken for the {}", found.front(), names.front()));
    return found.front();
}

std::string NpzArrays::list() const {
    std::string list;
    for (const auto& [name, entry] : entries_) {
        list += fmt::format("{}'{}' ", list.empty() ? "" : ", ", name);
        if (const auto found = peek(name)) {
            const NpyArray& array = found->array;
            list += fmt::format("{} {}", numpy_type_text(array.type, array.item_size),
                                numpy_shape_text(array.shape));
        } else {
            list += "(not read)";
        }
    }
    return list.empty() ? "nothing" : list;
}

OwnedArray NpzArrays::unpacked(const std::string& name) const {
    OwnedArray found;
    const auto bytes = unpack(entries_.at(name), path_, found.storage);
    found.array = parse_npy(bytes, place_of(name));
    return found;
}

/// An array if it can be read.
std::optional<OwnedArray> NpzArrays::peek(const std::string& name) const {
    try {
        return unpacked(name);
    } catch (const InputError&) {
        return std::nullopt;
    }
}

}  // namespace mscomp

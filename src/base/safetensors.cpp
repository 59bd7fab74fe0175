// SPDX-License-Identifier: MIT
#include "mscomp/base/safetensors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string_view>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "mapped_file.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "safetensors_header.h"

namespace mscomp {

static_assert(std::endian::native == std::endian::little, "files are little-endian");

namespace {

/// Largest items first: every tensor then starts at a multiple of its own item size.
std::vector<std::size_t> aligned_order(const std::vector<std::size_t>& item_sizes) {
    std::vector<std::size_t> order(item_sizes.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return item_sizes[a] > item_sizes[b]; });
    return order;
}

}  // namespace

std::size_t size_of(DataType type) {
    switch (type) {
        case DataType::u8:
            return 1;
        case DataType::f32:
        case DataType::i32:
            return 4;
        case DataType::f64:
        case DataType::i64:
        case DataType::u64:
            return 8;
    }
    throw std::logic_error("unknown data type");
}

void SafetensorsWriter::add_bytes(const std::string& name, DataType type, Shape shape,
                                  std::span<const std::byte> data) {
    const std::optional<std::uint64_t> wanted = byte_count(type, shape);
    if (!wanted || *wanted != data.size()) {
        throw std::logic_error(fmt::format("tensor '{}': {} bytes do not fill the shape [{}]", name,
                                           data.size(), fmt::join(shape, ", ")));
    }
    const bool taken = std::any_of(entries_.begin(), entries_.end(),
                                   [&](const Entry& entry) { return entry.name == name; });
    if (taken) throw std::logic_error("tensor '" + name + "' was added twice");
    entries_.push_back({name, type, std::move(shape), data});
}

void SafetensorsWriter::set_metadata(const std::string& key, std::string value) {
    metadata_[key] = std::move(value);
}

void SafetensorsWriter::write(const std::string& path) const {
    std::vector<std::size_t> item_sizes;
    for (const Entry& entry : entries_) item_sizes.push_back(size_of(entry.type));
    const std::vector<std::size_t> order = aligned_order(item_sizes);

    SafetensorsHeader header;
    header.metadata = metadata_;
    XXH3_state_t hash;
    XXH3_64bits_reset(&hash);
    std::uint64_t offset = 0;
    for (const std::size_t i : order) {
        const Entry& entry = entries_[i];
        header.tensors[entry.name] = {entry.type, entry.shape, offset, offset + entry.data.size()};
        offset += entry.data.size();
        if (!entry.data.empty()) XXH3_64bits_update(&hash, entry.data.data(), entry.data.size());
    }
    header.metadata[kHashKey] = fmt::format("{:016x}", XXH3_64bits_digest(&hash));

    AtomicFile file(path);
    file.write(header_text(header));
    for (const std::size_t i : order) file.write(entries_[i].data);
    file.commit();
}

struct SafetensorsFile::Mapping {
    explicit Mapping(const std::string& path) : file(path) {}

    struct Place {
        DataType type;
        Shape shape;
        std::span<const std::byte> data;
    };
    const Place& find(const std::string& name) const;

    MappedFile file;
    Metadata metadata;
    std::map<std::string, Place> tensors;
    std::vector<std::vector<std::byte>> aligned_copies;
};

const SafetensorsFile::Mapping::Place& SafetensorsFile::Mapping::find(
    const std::string& name) const {
    const auto found = tensors.find(name);
    if (found != tensors.end()) return found->second;
    std::vector<std::string> known;
    for (const auto& [other, place] : tensors) known.push_back(other);
    throw InputError(
        {file.path()},
        fmt::format("has no tensor '{}'; it holds {}", name,
                    known.empty() ? "none" : fmt::format("{}", fmt::join(known, ", "))));
}

SafetensorsFile::SafetensorsFile(const std::string& path)
    : mapping_(std::make_unique<Mapping>(path)) {
    SafetensorsHeader header = parse_header(mapping_->file.bytes(), path);
    const std::span<const std::byte> data = mapping_->file.bytes().subspan(header.data_begin);
    const auto hash = header.metadata.find(kHashKey);
    if (hash != header.metadata.end() && hash->second != hash_of(data)) {
        throw InputError({path},
                         "the data do not match their checksum; the file was altered or "
                         "damaged after it was written");
    }
    for (auto& [name, entry] : header.tensors) {
        std::span<const std::byte> raw = data.subspan(entry.begin, entry.end - entry.begin);
        if (reinterpret_cast<std::uintptr_t>(raw.data()) % size_of(entry.type) != 0) {
            raw = mapping_->aligned_copies.emplace_back(raw.begin(), raw.end());
        }
        mapping_->tensors[name] = {entry.type, std::move(entry.shape), raw};
    }
    mapping_->metadata = std::move(header.metadata);
}

SafetensorsFile::SafetensorsFile(SafetensorsFile&&) noexcept = default;
SafetensorsFile& SafetensorsFile::operator=(SafetensorsFile&&) noexcept = default;
SafetensorsFile::~SafetensorsFile() = default;

const std::string& SafetensorsFile::path() const { return mapping_->file.path(); }
const Metadata& SafetensorsFile::metadata() const { return mapping_->metadata; }
bool SafetensorsFile::contains(const std::string& name) const {
    return mapping_->tensors.contains(name);
}

std::vector<std::string> SafetensorsFile::names() const {
    std::vector<std::string> result;
    for (const auto& [name, place] : mapping_->tensors) result.push_back(name);
    return result;
}

DataType SafetensorsFile::type(const std::string& name) const { return mapping_->find(name).type; }
const Shape& SafetensorsFile::shape(const std::string& name) const {
    return mapping_->find(name).shape;
}

std::span<const std::byte> SafetensorsFile::bytes(const std::string& name, DataType type,
                                                  const Shape& shape) const {
    const Mapping::Place& place = mapping_->find(name);
    if (place.type != type) {
        throw InputError({path()}, fmt::format("tensor '{}' holds {}, wanted {}", name,
                                               name_of(place.type), name_of(type)));
    }
    const bool fits = std::equal(
        place.shape.begin(), place.shape.end(), shape.begin(), shape.end(),
        [](std::int64_t got, std::int64_t wanted) { return wanted == -1 || got == wanted; });
    if (!fits) {
        throw InputError({path()}, fmt::format("tensor '{}' has shape [{}], wanted [{}]", name,
                                               fmt::join(place.shape, ", "), shape_text(shape)));
    }
    return place.data;
}

}  // namespace mscomp

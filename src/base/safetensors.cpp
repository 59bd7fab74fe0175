// SPDX-License-Identifier: MIT
#include "mscomp/base/safetensors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string_view>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "mapped_file.h"
#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/safetensors_pieces.h"
#include "safetensors_header.h"

namespace mscomp {

static_assert(std::endian::native == std::endian::little, "files are little-endian");

namespace {

constexpr std::size_t kPieceBytes = std::size_t{4} << 20;

/// Reads all data of a mapped file once from end to end, without keeping them in memory.
class DataReading {
  public:
    DataReading(const MappedFile& file, const SafetensorsHeader& header, const PieceCheck& check) {
        XXH3_64bits_reset(&state_);
        std::vector<std::pair<const std::string*, const SafetensorsHeader::Tensor*>> order;
        for (const auto& [name, tensor] : header.tensors) order.emplace_back(&name, &tensor);
        std::sort(order.begin(), order.end(),
                  [](const auto& a, const auto& b) { return a.second->begin < b.second->begin; });
        for (const auto& [name, tensor] : order) {
            for (std::uint64_t place = tensor->begin; place < tensor->end; place += kPieceBytes) {
                const std::size_t begin = header.data_begin + place;
                const std::size_t size = std::min<std::size_t>(kPieceBytes, tensor->end - place);
                const std::span<const std::byte> bytes = file.bytes().subspan(begin, size);
                XXH3_64bits_update(&state_, bytes.data(), bytes.size());
                const auto first = (place - tensor->begin) / size_of(tensor->type);
                if (check && !refusal_) {
                    show(check, {*name, tensor->type, tensor->shape,
                                 static_cast<std::int64_t>(first), bytes});
                }
                file.forget(begin, begin + size);
            }
        }
    }
    std::string hash() const { return hash_text(XXH3_64bits_digest(&state_)); }
    void rethrow_refusal() const {
        if (refusal_) std::rethrow_exception(refusal_);
    }

  private:
    // A file that was damaged shall be called that, whatever else is wrong with it.
    void show(const PieceCheck& check, const SafetensorsPiece& piece) {
        try {
            check(piece);
        } catch (...) {
            refusal_ = std::current_exception();
        }
    }

    XXH3_state_t state_;
    std::exception_ptr refusal_;
};

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
    std::vector<SafetensorsPieceWriter::Tensor> tensors;
    for (const Entry& entry : entries_) tensors.push_back({entry.name, entry.type, entry.shape});
    SafetensorsPieceWriter writer(path, tensors, metadata_);
    for (const Entry& entry : entries_) writer.write_bytes(entry.name, entry.type, 0, entry.data);
    writer.finish();
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

SafetensorsFile::SafetensorsFile(const std::string& path, const PieceCheck& check)
    : mapping_(std::make_unique<Mapping>(path)) {
    SafetensorsHeader header = parse_header(mapping_->file.bytes(), path);
    const auto hash = header.metadata.find(kHashKey);
    const bool has_hash = hash != header.metadata.end();
    if (has_hash || check) {
        DataReading reading(mapping_->file, header, check);
        if (has_hash && hash->second != reading.hash()) {
            throw InputError({path},
                             "the data do not match their checksum; the file was altered or "
                             "damaged after it was written");
        }
        reading.rethrow_refusal();
    }
    const std::span<const std::byte> data = mapping_->file.bytes().subspan(header.data_begin);
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

void SafetensorsFile::forget(std::span<const std::byte> data) const {
    const std::span<const std::byte> whole = mapping_->file.bytes();
    // What had to be copied to be aligned stays.
    if (data.data() < whole.data() || data.data() >= whole.data() + whole.size()) return;
    const auto begin = at(data.data() - whole.data());
    mapping_->file.forget(begin, begin + data.size());
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

// SPDX-License-Identifier: MIT
#include "safetensors_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "json_check.h"
#include "mscomp/base/error.h"
#include "mscomp/base/file_kind.h"

namespace mscomp {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kLengthBytes = 8;
constexpr std::size_t kMostLevels = 16;
constexpr const char* kMetadataKey = "__metadata__";
constexpr std::array<std::pair<DataType, std::string_view>, 6> kTypes{{{DataType::f32, "F32"},
                                                                       {DataType::f64, "F64"},
                                                                       {DataType::i32, "I32"},
                                                                       {DataType::i64, "I64"},
                                                                       {DataType::u8, "U8"},
                                                                       {DataType::u64, "U64"}}};

std::uint64_t read_length(std::span<const std::byte> bytes, const std::string& path) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (!text.substr(std::min(kLengthBytes, text.size())).starts_with('{')) {
        refuse_other_kinds(text, path);
    }
    if (bytes.size() < kLengthBytes) {
        throw InputError({path}, fmt::format("not a safetensors file: {} bytes, wanted at least 8",
                                             bytes.size()));
    }
    std::uint64_t length = 0;
    std::memcpy(&length, bytes.data(), kLengthBytes);
    if (length > bytes.size() - kLengthBytes) {
        throw InputError(
            {path}, fmt::format("truncated or not a safetensors file: the header shall have {} "
                                "bytes, the file has {} after its first 8",
                                length, bytes.size() - kLengthBytes));
    }
    return length;
}

/// Throws InputError.
class HeaderCheck final : public JsonCheck {
  public:
    explicit HeaderCheck(const std::string& path) : JsonCheck(kMostLevels), path_(path) {}

    bool parse_error(std::size_t byte, const std::string&, const Json::exception&) override {
        throw InputError({path_}, fmt::format("the header is not JSON, at its byte {}", byte));
    }

  private:
    void fail_repeated(const std::string& name) const override {
        throw InputError({path_}, fmt::format("the header names '{}' twice", name));
    }
    void fail_deep(std::size_t most_levels) const override {
        throw InputError({path_}, fmt::format("the header is nested deeper than {} levels, "
                                              "wanted 3",
                                              most_levels));
    }

    const std::string& path_;
};

Json parse_object(std::string_view text, const std::string& path) {
    // The parser takes a zero byte for the end of its input.
    if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos) {
        throw InputError({path}, fmt::format("the header is not JSON, at its byte {}", zero + 1));
    }
    HeaderCheck check(path);
    Json::sax_parse(text, &check);
    Json header = Json::parse(text);
    if (!header.is_object()) {
        throw InputError(
            {path}, fmt::format("the header is a JSON {}, wanted an object", header.type_name()));
    }
    return header;
}

/// The same for every way of writing the same JSON.
std::string canonical_text(const Json& header) {
    // File names need not be UTF-8, JSON must be.
    return header.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string hash_of_text(const std::string& text) {
    return hash_of(std::as_bytes(std::span<const char>(text)));
}

void check_header_hash(Json header, const Metadata& metadata, const std::string& path) {
    const auto hash = metadata.find(kHeaderHashKey);
    if (hash == metadata.end()) return;
    header[kMetadataKey].erase(kHeaderHashKey);
    if (hash->second == hash_of_text(canonical_text(header))) return;
    throw InputError({path},
                     "the header does not match its checksum; the file was altered or "
                     "damaged after it was written");
}

Metadata read_metadata(const Json& object, const std::string& path) {
    if (!object.is_object()) {
        throw InputError({path}, fmt::format("{} is a JSON {}, wanted an object", kMetadataKey,
                                             object.type_name()));
    }
    Metadata metadata;
    for (const auto& [key, value] : object.items()) {
        if (!value.is_string()) {
            throw InputError({path}, fmt::format("{}: '{}' is a JSON {}, wanted a string",
                                                 kMetadataKey, key, value.type_name()));
        }
        metadata[key] = value.get<std::string>();
    }
    return metadata;
}

/// The member `key` of a tensor's entry as a list of whole numbers from 0 to 2^63 - 1.
std::vector<std::int64_t> read_counts(const Json& entry, const char* key, const std::string& name,
                                      const std::string& path) {
    const auto fail = [&] {
        throw InputError({path}, fmt::format("tensor '{}': '{}' is not a list of whole numbers "
                                             "from 0 to 2^63 - 1",
                                             name, key));
    };
    const auto list = entry.find(key);
    if (list == entry.end() || !list->is_array()) fail();
    std::vector<std::int64_t> counts;
    for (const Json& value : *list) {
        if (!value.is_number_unsigned() ||
            value.get<std::uint64_t>() >
                static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
            fail();
        }
        counts.push_back(value.get<std::int64_t>());
    }
    return counts;
}

DataType read_type(const Json& entry, const std::string& name, const std::string& path) {
    const auto text = entry.find("dtype");
    if (text == entry.end() || !text->is_string()) {
        throw InputError({path}, fmt::format("tensor '{}' has no 'dtype'", name));
    }
    for (const auto& [type, known] : kTypes) {
        if (text->get_ref<const std::string&>() == known) return type;
    }
    throw InputError(
        {path}, fmt::format("tensor '{}' holds '{}', wanted F32, F64, I32, I64, U8 or U64", name,
                            text->get_ref<const std::string&>()));
}

SafetensorsHeader::Tensor read_tensor(const Json& entry, const std::string& name,
                                      std::uint64_t data_size, const std::string& path) {
    if (!entry.is_object()) {
        throw InputError({path}, fmt::format("tensor '{}' is a JSON {}, wanted an object", name,
                                             entry.type_name()));
    }
    SafetensorsHeader::Tensor tensor{read_type(entry, name, path),
                                     read_counts(entry, "shape", name, path), 0, 0};
    const std::vector<std::int64_t> offsets = read_counts(entry, "data_offsets", name, path);
    if (offsets.size() != 2 || offsets[0] > offsets[1]) {
        throw InputError({path},
                         fmt::format("tensor '{}': 'data_offsets' is not a begin and an end "
                                     "not before it",
                                     name));
    }
    tensor.begin = static_cast<std::uint64_t>(offsets[0]);
    tensor.end = static_cast<std::uint64_t>(offsets[1]);
    if (tensor.end > data_size) {
        throw InputError({path},
                         fmt::format("tensor '{}' ends at byte {} of the data, the file has "
                                     "{}; it may be truncated",
                                     name, tensor.end, data_size));
    }
    const std::optional<std::uint64_t> wanted = byte_count(tensor.type, tensor.shape);
    if (!wanted || *wanted != tensor.end - tensor.begin) {
        throw InputError({path}, fmt::format("tensor '{}' has shape [{}] of {}, which does not fit "
                                             "its {} bytes",
                                             name, shape_text(tensor.shape), name_of(tensor.type),
                                             tensor.end - tensor.begin));
    }
    return tensor;
}

void check_no_hole_or_overlap(const SafetensorsHeader& header, std::uint64_t data_size,
                              const std::string& path) {
    std::vector<std::pair<std::string_view, const SafetensorsHeader::Tensor*>> order;
    for (const auto& [name, tensor] : header.tensors) order.emplace_back(name, &tensor);
    std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
        return std::pair(a.second->begin, a.second->end) <
               std::pair(b.second->begin, b.second->end);
    });
    std::uint64_t at = 0;
    for (const auto& [name, tensor] : order) {
        if (tensor->begin != at) {
            throw InputError({path},
                             fmt::format("tensor '{}' begins at byte {} of the data, wanted "
                                         "{}: {}",
                                         name, tensor->begin, at,
                                         tensor->begin < at ? "it overlaps another"
                                                            : "there is a hole before it"));
        }
        at = tensor->end;
    }
    if (at != data_size) {
        throw InputError({path}, fmt::format("the tensors end at byte {} of the data, the file has "
                                             "{}",
                                             at, data_size));
    }
}

}  // namespace

std::string hash_text(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

std::string hash_of(std::span<const std::byte> bytes) {
    return hash_text(XXH3_64bits(bytes.data(), bytes.size()));
}

std::string_view name_of(DataType type) {
    for (const auto& [known, name] : kTypes) {
        if (known == type) return name;
    }
    throw std::logic_error("unknown data type");
}

std::string shape_text(const Shape& shape) {
    std::string text;
    for (const std::int64_t length : shape) {
        if (!text.empty()) text += ", ";
        text += length == -1 ? "any" : std::to_string(length);
    }
    return text;
}

std::optional<std::uint64_t> byte_count(DataType type, const Shape& shape) {
    std::uint64_t bytes = size_of(type);
    for (const std::int64_t length : shape) {
        if (length < 0 ||
            __builtin_mul_overflow(bytes, static_cast<std::uint64_t>(length), &bytes)) {
            return std::nullopt;
        }
    }
    return bytes;
}

std::string header_text(const SafetensorsHeader& header, std::size_t size) {
    Json json = Json::object();
    json[kMetadataKey] = header.metadata;
    for (const auto& [name, tensor] : header.tensors) {
        json[name] = {{"dtype", name_of(tensor.type)},
                      {"shape", tensor.shape},
                      {"data_offsets", {tensor.begin, tensor.end}}};
    }
    json = Json::parse(canonical_text(json));
    json[kMetadataKey][kHeaderHashKey] = hash_of_text(canonical_text(json));
    std::string text = canonical_text(json);
    if (size > kLengthBytes + text.size()) text.resize(size - kLengthBytes, ' ');
    text.append((kLengthBytes - text.size() % kLengthBytes) % kLengthBytes, ' ');
    const std::uint64_t length = text.size();
    std::string bytes(kLengthBytes, '\0');
    std::memcpy(bytes.data(), &length, kLengthBytes);
    return bytes + text;
}

SafetensorsHeader parse_header(std::span<const std::byte> bytes, const std::string& path) {
    const std::uint64_t length = read_length(bytes, path);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()) + kLengthBytes, length);
    SafetensorsHeader header;
    header.data_begin = kLengthBytes + length;
    const std::uint64_t data_size = bytes.size() - header.data_begin;
    const Json json = parse_object(text, path);
    for (const auto& [name, entry] : json.items()) {
        if (name == kMetadataKey) {
            header.metadata = read_metadata(entry, path);
        } else {
            header.tensors[name] = read_tensor(entry, name, data_size, path);
        }
    }
    check_no_hole_or_overlap(header, data_size, path);
    check_header_hash(json, header.metadata, path);
    return header;
}

}  // namespace mscomp

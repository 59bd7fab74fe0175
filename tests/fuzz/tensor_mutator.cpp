// SPDX-License-Identifier: MIT
#include <algorithm>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "base/safetensors_header.h"
#include "fuzz/mutators.h"
#include "fuzz/promises.h"

namespace mscomp::fuzz {
namespace {

struct NamedTensor {
    std::string name;
    DataType type;
    Shape shape;
    std::string data;
};

/// A sound file taken apart, and put together again with lengths, offsets and hashes as they have
/// to be.
struct TensorParts {
    explicit TensorParts(std::string_view file) {
        SafetensorsHeader header = parse_header(bytes_of(file), "");
        metadata = std::move(header.metadata);
        for (const auto& [name, tensor] : header.tensors) {
            tensors.push_back({name, tensor.type, tensor.shape,
                               std::string(file.substr(header.data_begin + tensor.begin,
                                                       tensor.end - tensor.begin))});
        }
    }
    std::string joined() const {
        SafetensorsHeader header;
        std::string data;
        for (const NamedTensor& tensor : tensors) {
            header.tensors[tensor.name] = {tensor.type, tensor.shape, data.size(),
                                           data.size() + tensor.data.size()};
            data += tensor.data;
        }
        header.metadata = metadata;
        if (header.metadata.contains(kHashKey)) header.metadata[kHashKey] = hash_of(bytes_of(data));
        header.metadata.erase(kHeaderHashKey);
        return header_text(header) + data;
    }

    Metadata metadata;
    std::vector<NamedTensor> tensors;
};

/// As many bytes as the shape needs, zeros where there were none.
void fill(NamedTensor& tensor, std::size_t most) {
    const std::size_t bytes = byte_count(tensor.type, tensor.shape).value_or(most + 1);
    if (bytes > most) throw std::length_error("too large");
    tensor.data.resize(bytes);
}

/// A model file keeps a JSON text in its metadata, and in that the YAML of its configuration.
std::string changed_description(const std::string& text, std::size_t most, std::mt19937& random) {
    nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
    if (random() % 4 == 0 || !json.is_object()) return changed(text, most);
    auto entry = json.begin();
    std::advance(entry, random() % json.size());
    if (random() % 2 == 0 && json.contains("config")) entry = json.find("config");
    if (entry->is_string()) {
        *entry = changed(entry->get<std::string>(), most);
    } else {
        *entry = nlohmann::json::parse(changed(entry->dump(), most), nullptr, false);
    }
    return json.dump();
}

void change_metadata(TensorParts& parts, std::size_t most, std::mt19937& random) {
    if (parts.metadata.empty()) return;
    auto entry = parts.metadata.begin();
    std::advance(entry, random() % parts.metadata.size());
    if (parts.metadata.contains("model")) entry = parts.metadata.find("model");
    entry->second = changed_description(entry->second, most, random);
}

std::int64_t other_length(std::int64_t length, std::mt19937& random) {
    const std::array<std::int64_t, 6> others{
        0, 1, 2, length + 1, std::max<std::int64_t>(length, 1) - 1, 2 * length};
    return others[random() % others.size()];
}

/// One axis, or all that are as long: what belongs together stays together.
void change_length(TensorParts& parts, std::size_t most, std::mt19937& random) {
    NamedTensor& one = parts.tensors[random() % parts.tensors.size()];
    if (one.shape.empty()) return;
    std::int64_t& length = one.shape[random() % one.shape.size()];
    const std::int64_t before = length, after = other_length(before, random);
    length = after;
    const bool everywhere = random() % 2 == 0;
    for (NamedTensor& tensor : parts.tensors) {
        if (everywhere) std::ranges::replace(tensor.shape, before, after);
        fill(tensor, most);
    }
}

void change_type(NamedTensor& tensor, std::size_t most, std::mt19937& random) {
    constexpr std::array kTypes{DataType::f32, DataType::f64, DataType::i32,
                                DataType::i64, DataType::u8,  DataType::u64};
    tensor.type = kTypes[random() % kTypes.size()];
    fill(tensor, most);
}

/// A number of its own choice in the place of one that stands there.
void change_number(NamedTensor& tensor, std::mt19937& random) {
    if (tensor.data.empty()) return;
    const std::size_t size = size_of(tensor.type);
    const std::size_t at = random() % (tensor.data.size() / size) * size;
    constexpr std::array kDoubles{0.0,
                                  -0.0,
                                  1e300,
                                  -1e38,
                                  1e-40,
                                  0.5,
                                  std::numeric_limits<double>::infinity(),
                                  std::numeric_limits<double>::quiet_NaN()};
    const double value = kDoubles[random() % kDoubles.size()];
    const auto as_float = static_cast<float>(value);
    const auto number = static_cast<std::int64_t>(random() % 8) - 2;
    const void* from = tensor.type == DataType::f64   ? static_cast<const void*>(&value)
                       : tensor.type == DataType::f32 ? static_cast<const void*>(&as_float)
                                                      : static_cast<const void*>(&number);
    std::memcpy(tensor.data.data() + at, from, size);
}

void change_tensor(TensorParts& parts, std::size_t most, std::mt19937& random) {
    if (parts.tensors.empty()) return;
    const std::size_t index = random() % parts.tensors.size();
    NamedTensor& tensor = parts.tensors[index];
    switch (random() % 8) {
        case 0:
            return change_length(parts, most, random);
        case 1:
            return change_type(tensor, most, random);
        case 2:
            tensor.name = changed(tensor.name, most);
            return;
        case 3:
            parts.tensors.erase(parts.tensors.begin() + static_cast<std::ptrdiff_t>(index));
            return;
        case 4:
        case 5:
            return change_number(tensor, random);
        default: {
            const std::size_t size = tensor.data.size();
            tensor.data = changed(tensor.data, most);
            tensor.data.resize(size);
        }
    }
}

/// The header as text, with the length that it then has.
std::string with_changed_header(std::string_view file, std::size_t most) {
    std::uint64_t length = 0;
    std::memcpy(&length, file.data(), sizeof length);
    length = std::min<std::uint64_t>(length, file.size() - sizeof length);
    const std::string header = changed(std::string(file.substr(sizeof length, length)), most);
    std::string result(sizeof length, '\0');
    const std::uint64_t now = header.size();
    std::memcpy(result.data(), &now, sizeof now);
    return result + header + std::string(file.substr(sizeof length + length));
}

}  // namespace

std::optional<std::string> changed_tensors(std::string_view file, std::size_t most, unsigned seed) {
    if (file.size() <= sizeof(std::uint64_t)) return std::nullopt;
    std::mt19937 random(seed);
    if (random() % 8 == 0) return with_changed_header(file, most);
    try {
        TensorParts parts(file);
        if (random() % 2 == 0) {
            change_metadata(parts, most, random);
        } else {
            change_tensor(parts, most, random);
        }
        return parts.joined();
    } catch (const std::exception&) {  // broken already, or by the change
        return with_changed_header(file, most);
    }
}

}  // namespace mscomp::fuzz

// SPDX-License-Identifier: MIT
#include "base/safetensors_header.h"
#include "base/temporary_folder.h"
#include "fuzz/feature_promises.h"
#include "fuzz/memory_file.h"
#include "fuzz/promises.h"
#include "fuzz/targets.h"
#include "mscomp/acap/feature_file.h"

namespace mscomp::fuzz {
namespace {

bool same_tensors(const SafetensorsHeader& a, const SafetensorsHeader& b) {
    return std::equal(a.tensors.begin(), a.tensors.end(), b.tensors.begin(), b.tensors.end(),
                      [](const auto& x, const auto& y) {
                          return x.first == y.first && x.second.type == y.second.type &&
                                 x.second.shape == y.second.shape &&
                                 x.second.begin == y.second.begin && x.second.end == y.second.end;
                      });
}

void check_round_trip(SafetensorsHeader header, std::string_view data) {
    header.metadata.erase(kHeaderHashKey);
    const std::string text = header_text(header);
    SafetensorsHeader again = parse_header(bytes_of(text + std::string(data)), "again");
    require(again.data_begin == text.size() && text.size() % 8 == 0, "data begin at 8 bytes");
    again.metadata.erase(kHeaderHashKey);
    require(again.metadata == header.metadata && same_tensors(again, header),
            "a header survives writing and reading");
}

template <class T>
std::size_t size_read(const SafetensorsFile& file, const std::string& name) {
    const std::span<const T> data = file.data<T>(name, file.shape(name));
    const std::vector<T> copy(data.begin(), data.end());  // every element can be read
    return copy.size();
}

std::size_t size_read(const SafetensorsFile& file, const std::string& name) {
    switch (file.type(name)) {
        case DataType::f32:
            return size_read<float>(file, name);
        case DataType::f64:
            return size_read<double>(file, name);
        case DataType::i32:
            return size_read<std::int32_t>(file, name);
        case DataType::i64:
            return size_read<std::int64_t>(file, name);
        case DataType::u8:
            return size_read<std::uint8_t>(file, name);
        case DataType::u64:
            return size_read<std::uint64_t>(file, name);
    }
    return 0;
}

void check_tensors(const SafetensorsFile& file, const SafetensorsHeader& header) {
    require(file.names().size() == header.tensors.size(), "all tensors are there");
    for (const auto& [name, tensor] : header.tensors) {
        std::size_t count = 1;
        for (const std::int64_t length : file.shape(name))
            count *= static_cast<std::size_t>(length);
        require(size_read(file, name) == count, "a tensor has as many elements as its shape");
    }
}

void check_round_trip(const FeatureSet& set) {
    static const TemporaryFolder folder;
    const std::string path = folder / "set.safetensors";
    write_features(path, set);
    check_same(read_features(path), set);
}

}  // namespace

void check_safetensors(std::span<const std::byte> input) {
    static const MemoryFile memory;
    const auto header = unless_refused("input", [&] { return parse_header(input, "input"); });
    const std::string path = memory.filled_with(input);
    const auto file = unless_refused(path, [&] { return SafetensorsFile(path); });
    const auto set = unless_refused(path, [&] { return read_features(path); });
    require(header || !file, "a file is refused if its header is");
    require(file || !set, "a set is refused if its file is");
    if (header) check_round_trip(*header, text_of(input.subspan(header->data_begin)));
    if (file) check_tensors(*file, *header);
    if (!set) return;
    check_sound(*set);
    check_round_trip(*set);
}

}  // namespace mscomp::fuzz

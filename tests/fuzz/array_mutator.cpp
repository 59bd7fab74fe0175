// SPDX-License-Identifier: MIT
#include <zlib.h>

#include <cstring>
#include <random>
#include <vector>

#include "fuzz/mutators.h"
#include "fuzz/promises.h"
#include "mscomp/convert/zip.h"

namespace mscomp::fuzz {
namespace {

struct File {
    std::string name, content;
};

std::vector<File> unpacked(std::string_view archive) {
    std::vector<File> files;
    for (const ZipEntry& entry : read_zip_entries(bytes_of(archive), "")) {
        std::vector<std::byte> storage;
        files.push_back({entry.name, std::string(text_of(unpack(entry, "", storage)))});
    }
    return files;
}

template <class... Number>
void put(std::string& bytes, Number... numbers) {
    const auto put_one = [&](auto number) {
        for (std::size_t i = 0; i < sizeof number; ++i) {
            bytes += static_cast<char>(number >> (8 * i) & 0xff);
        }
    };
    (put_one(numbers), ...);
}

/// What the header of a stored file and its entry in the directory have in common.
void put_description(std::string& bytes, const File& file) {
    const auto size = static_cast<std::uint32_t>(file.content.size());
    const auto crc = static_cast<std::uint32_t>(
        ::crc32(0, reinterpret_cast<const Bytef*>(file.content.data()), size));
    constexpr std::uint16_t kVersion = 20, kNone = 0;
    put(bytes, kVersion, kNone, kNone, kNone, kNone, crc, size, size,
        static_cast<std::uint16_t>(file.name.size()), kNone);
}

std::string packed(const std::vector<File>& files) {
    constexpr std::uint16_t kVersion = 20, kNone = 0;
    std::string archive, directory;
    for (const File& file : files) {
        directory += "PK\x01\x02";
        put(directory, kVersion);
        put_description(directory, file);
        put(directory, kNone, kNone, kNone, std::uint32_t{0},
            static_cast<std::uint32_t>(archive.size()));
        directory += file.name;
        archive += "PK\x03\x04";
        put_description(archive, file);
        archive += file.name + file.content;
    }
    const auto count = static_cast<std::uint16_t>(files.size());
    const auto begin = static_cast<std::uint32_t>(archive.size());
    archive += directory + "PK\x05\x06";
    put(archive, kNone, kNone, count, count, static_cast<std::uint32_t>(directory.size()), begin,
        kNone);
    return archive;
}

/// Header or data of an array, with the length of the header as it then is.
std::string changed_array(const std::string& array, std::size_t most, std::mt19937& random) {
    constexpr std::size_t kPrefix = 10;  // magic, version and a length of 16 bits
    if (array.size() < kPrefix) return changed(array, most);
    const auto low = static_cast<unsigned char>(array[8]),
               high = static_cast<unsigned char>(array[9]);
    const std::size_t length = std::min<std::size_t>(low + 256U * high, array.size() - kPrefix);
    std::string header = array.substr(kPrefix, length), data = array.substr(kPrefix + length);
    if (random() % 2 == 0) {
        header = changed(header, std::min<std::size_t>(most, 0xffff));
    } else if (random() % 2 == 0) {
        data = changed(data, most);
    } else {
        const std::size_t size = data.size();
        data = changed(data, most);
        data.resize(size);
    }
    std::string result = array.substr(0, 8);
    put(result, static_cast<std::uint16_t>(header.size()));
    return result + header + data;
}

}  // namespace

std::optional<std::string> changed_arrays(std::string_view file, std::size_t most, unsigned seed) {
    std::mt19937 random(seed);
    if (random() % 16 == 0) return std::nullopt;
    std::vector<File> files;
    try {
        files = unpacked(file);
    } catch (const std::exception&) {
        return std::nullopt;
    }
    if (files.empty()) return std::nullopt;
    const std::size_t index = random() % files.size();
    switch (random() % 8) {
        case 0:
            files.erase(files.begin() + static_cast<std::ptrdiff_t>(index));
            break;
        case 1:
            files[index].name = changed(files[index].name, most);
            break;
        case 2:
            files.push_back({files[random() % files.size()].name, files[index].content});
            break;
        default:
            files[index].content = changed_array(files[index].content, most, random);
    }
    return packed(files);
}

}  // namespace mscomp::fuzz

// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace mscomp {

enum class DataType { f32, f64, i32, i64, u8, u64 };
std::size_t size_of(DataType type);
template <class T>
constexpr DataType data_type_of();
template <>
constexpr DataType data_type_of<float>() {
    return DataType::f32;
}
template <>
constexpr DataType data_type_of<double>() {
    return DataType::f64;
}
template <>
constexpr DataType data_type_of<std::int32_t>() {
    return DataType::i32;
}
template <>
constexpr DataType data_type_of<std::int64_t>() {
    return DataType::i64;
}
template <>
constexpr DataType data_type_of<std::uint8_t>() {
    return DataType::u8;
}
template <>
constexpr DataType data_type_of<std::uint64_t>() {
    return DataType::u64;
}

using Shape = std::vector<std::int64_t>;
using Metadata = std::map<std::string, std::string>;

/// Writes a safetensors file (8-byte length, JSON header padded to 8, raw little-endian data) as
/// one atomic step: add what it shall hold (borrowed until write), then write. The metadata always
/// get "xxh3", the XXH3-64 of the data part as 16 hex digits, and "xxh3_header", that of the header
/// without this entry; the file is read back and checked before it takes its name.
class SafetensorsWriter {
  public:
    template <class T>
    void add(const std::string& name, Shape shape, std::span<const T> data) {
        add_bytes(name, data_type_of<T>(), std::move(shape), std::as_bytes(data));
    }
    void set_metadata(const std::string& key, std::string value);
    /// Throws IoError; then nothing is left behind and an earlier file of that name still stands.
    void write(const std::string& path) const;

  private:
    struct Entry {
        std::string name;
        DataType type;
        Shape shape;
        std::span<const std::byte> data;
    };
    void add_bytes(const std::string& name, DataType type, Shape shape,
                   std::span<const std::byte> data);

    std::vector<Entry> entries_;
    Metadata metadata_;
};

/// Some consecutive elements of a tensor, which need not be aligned for their type.
struct SafetensorsPiece {
    const std::string& name;
    DataType type;
    const Shape& shape;  // of the whole tensor
    std::int64_t first;  // number of the first element
    std::span<const std::byte> bytes;
};
/// Looks at the tensors, piece by piece in the order of the file; throws to refuse it.
using PieceCheck = std::function<void(const SafetensorsPiece&)>;

/// A safetensors file, memory-mapped and strictly checked: lengths and ranges against the real file
/// before anything is allocated, no overlap, no holes, known types, overflow-checked shapes, and
/// both hashes wherever the metadata have them.
class SafetensorsFile {
  public:
    /// Throws IoError (cannot be read) or InputError (not a sound safetensors file, says what and
    /// where).
    explicit SafetensorsFile(const std::string& path) : SafetensorsFile(path, {}) {}
    /// As above; `check` sees the data while they are read from end to end for the hash. What it
    /// throws is thrown if the hash is right.
    SafetensorsFile(const std::string& path, const PieceCheck& check);
    SafetensorsFile(SafetensorsFile&&) noexcept;
    SafetensorsFile& operator=(SafetensorsFile&&) noexcept;
    ~SafetensorsFile();

    const std::string& path() const;
    const Metadata& metadata() const;
    bool contains(const std::string& name) const;
    std::vector<std::string> names() const;
    /// Throws InputError if there is no such tensor.
    DataType type(const std::string& name) const;
    const Shape& shape(const std::string& name) const;

    /// The data of `name` where it lies in the mapped file. Throws InputError naming the tensor if
    /// it is missing or has another type or shape; a -1 in `shape` accepts any length.
    template <class T>
    std::span<const T> data(const std::string& name, const Shape& shape) const {
        const std::span<const std::byte> raw = bytes(name, data_type_of<T>(), shape);
        return {reinterpret_cast<const T*>(raw.data()), raw.size() / sizeof(T)};
    }

    /// These bytes, a part of what data() returned, need not stay in memory; they are read again
    /// when they are used. So that working through a large file does not fill the memory.
    void forget(std::span<const std::byte> data) const;

  private:
    struct Mapping;
    std::span<const std::byte> bytes(const std::string& name, DataType type,
                                     const Shape& shape) const;
    std::unique_ptr<Mapping> mapping_;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/safetensors.h"

namespace mscomp {

/// Writes a safetensors file piece by piece, for data larger than memory. What it holds is declared
/// first; pieces come in any order, those of different ranges from several threads at once. Nothing
/// stands under the final name before finish(), and nothing is left behind without it.
class SafetensorsPieceWriter {
  public:
    struct Tensor {
        std::string name;
        DataType type;
        Shape shape;
    };
    /// Claims the room on the disk for all `tensors`, for `metadata`, and for `reserve` bytes of
    /// metadata that are known at the end only. Throws IoError.
    SafetensorsPieceWriter(const std::string& path, const std::vector<Tensor>& tensors,
                           const Metadata& metadata = {}, std::size_t reserve = 0);
    SafetensorsPieceWriter(SafetensorsPieceWriter&&) noexcept;
    SafetensorsPieceWriter& operator=(SafetensorsPieceWriter&&) noexcept;
    ~SafetensorsPieceWriter();

    /// The elements of `name` from number `first` on. A piece may be written again, as it was or as
    /// part of a larger one. Throws IoError.
    template <class T>
    void write(const std::string& name, std::int64_t first, std::span<const T> data) {
        write_bytes(name, data_type_of<T>(), first, std::as_bytes(data));
    }
    /// What was written there, one or several whole pieces. Throws IoError if the disk gives back
    /// something else.
    template <class T>
    void read(const std::string& name, std::int64_t first, std::span<T> data) const {
        read_bytes(name, data_type_of<T>(), first, std::as_writable_bytes(data));
    }

    /// Whether the header has room for `more` beside the metadata given at first.
    bool has_room_for(const Metadata& more) const;
    /// Adds `more` to the metadata and makes the file appear under its name: synced, read once from
    /// end to end for the checksum and to compare every piece with what was written. Everything has
    /// to have been written. Throws IoError; an earlier file of that name then still stands.
    void finish(const Metadata& more = {});

  private:
    friend class SafetensorsWriter;
    struct State;
    void write_bytes(const std::string& name, DataType type, std::int64_t first,
                     std::span<const std::byte> data);
    void read_bytes(const std::string& name, DataType type, std::int64_t first,
                    std::span<std::byte> data) const;

    std::unique_ptr<State> state_;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#include "mscomp/base/safetensors_pieces.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "safetensors_header.h"
#include "temporary_file.h"
#include "written_pieces.h"

namespace mscomp {
namespace {

using Tensor = SafetensorsPieceWriter::Tensor;

/// Largest items first: every tensor then starts at a multiple of its own item size.
std::vector<std::size_t> aligned_order(const std::vector<Tensor>& tensors) {
    std::vector<std::size_t> order(tensors.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return size_of(tensors[a].type) > size_of(tensors[b].type);
    });
    return order;
}

SafetensorsHeader header_of(const std::vector<Tensor>& tensors, const Metadata& metadata) {
    SafetensorsHeader header;
    header.metadata = metadata;
    std::uint64_t offset = 0;
    for (const std::size_t i : aligned_order(tensors)) {
        const Tensor& tensor = tensors[i];
        const std::optional<std::uint64_t> bytes = byte_count(tensor.type, tensor.shape);
        if (!bytes) {
            throw std::logic_error(fmt::format("tensor '{}' cannot have the shape [{}]",
                                               tensor.name, fmt::join(tensor.shape, ", ")));
        }
        const bool is_new =
            header.tensors
                .emplace(tensor.name, SafetensorsHeader::Tensor{tensor.type, tensor.shape, offset,
                                                                offset + *bytes})
                .second;
        if (!is_new) throw std::logic_error("tensor '" + tensor.name + "' was declared twice");
        offset += *bytes;
    }
    header.metadata[kHashKey] = std::string(hash_of({}).size(), '0');
    return header;
}

std::uint64_t data_size_of(const SafetensorsHeader& header) {
    std::uint64_t size = 0;
    for (const auto& [name, tensor] : header.tensors) size = std::max(size, tensor.end);
    return size;
}

}  // namespace

struct SafetensorsPieceWriter::State {
    State(const std::string& path, SafetensorsHeader declared, std::size_t reserve)
        : file(path), header(std::move(declared)), data_size(data_size_of(header)) {
        header.data_begin = header_text(header, header_text(header).size() + reserve).size();
        file.reserve(header.data_begin + data_size);
    }

    /// Where `size` bytes from element `first` of `name` lie in the data.
    std::uint64_t place(const std::string& name, DataType type, std::int64_t first,
                        std::size_t size) const {
        const auto found = header.tensors.find(name);
        if (found == header.tensors.end() || found->second.type != type) {
            throw std::logic_error(fmt::format("no tensor '{}' of {}", name, name_of(type)));
        }
        const SafetensorsHeader::Tensor& tensor = found->second;
        const std::uint64_t length = tensor.end - tensor.begin;
        const auto offset = static_cast<std::uint64_t>(first) * size_of(type);
        if (first < 0 || offset > length || size > length - offset) {
            throw std::logic_error(
                fmt::format("tensor '{}': {} bytes from element {} on are more "
                            "than its {} bytes",
                            name, size, first, length));
        }
        return tensor.begin + offset;
    }
    void check_complete() const {
        const std::optional<std::uint64_t> hole = pieces.first_hole(data_size);
        if (!hole) return;
        for (const auto& [name, tensor] : header.tensors) {
            if (*hole < tensor.begin || *hole >= tensor.end) continue;
            throw std::logic_error(fmt::format("tensor '{}' was never written from element {} on",
                                               name,
                                               (*hole - tensor.begin) / size_of(tensor.type)));
        }
    }
    SafetensorsHeader header_with(const Metadata& more) const {
        SafetensorsHeader result = header;
        for (const auto& [key, value] : more) result.metadata[key] = value;
        return result;
    }

    TemporaryFile file;
    SafetensorsHeader header;
    std::uint64_t data_size;
    WrittenPieces pieces;
};

SafetensorsPieceWriter::SafetensorsPieceWriter(const std::string& path,
                                               const std::vector<Tensor>& tensors,
                                               const Metadata& metadata, std::size_t reserve)
    : state_(std::make_unique<State>(path, header_of(tensors, metadata), reserve)) {}
SafetensorsPieceWriter::SafetensorsPieceWriter(SafetensorsPieceWriter&&) noexcept = default;
SafetensorsPieceWriter& SafetensorsPieceWriter::operator=(SafetensorsPieceWriter&&) noexcept =
    default;
SafetensorsPieceWriter::~SafetensorsPieceWriter() = default;

void SafetensorsPieceWriter::write_bytes(const std::string& name, DataType type, std::int64_t first,
                                         std::span<const std::byte> data) {
    const std::uint64_t place = state_->place(name, type, first, data.size());
    state_->pieces.note(place, data);
    state_->file.write(state_->header.data_begin + place, data);
}

void SafetensorsPieceWriter::read_bytes(const std::string& name, DataType type, std::int64_t first,
                                        std::span<std::byte> data) const {
    const std::uint64_t place = state_->place(name, type, first, data.size());
    const bool is_whole = state_->file.read(state_->header.data_begin + place, data) == data.size();
    // What is computed from it would have a valid checksum.
    if (!is_whole || !state_->pieces.agrees(place, data)) state_->file.fail_comparison();
}

bool SafetensorsPieceWriter::has_room_for(const Metadata& more) const {
    return header_text(state_->header_with(more)).size() <= state_->header.data_begin;
}

void SafetensorsPieceWriter::finish(const Metadata& more) {
    state_->check_complete();
    if (!has_room_for(more)) throw std::logic_error("the header has no room for the metadata");
    state_->file.sync();
    SafetensorsHeader header = state_->header_with(more);
    header.metadata[kHashKey] =
        hash_text(state_->pieces.checked_hash(state_->file, header.data_begin, state_->data_size));
    const std::string text = header_text(header, header.data_begin);
    state_->file.write(0, std::as_bytes(std::span<const char>(text)));
    state_->file.sync();
    std::string found(text.size(), '\0');
    state_->file.read(0, std::as_writable_bytes(std::span<char>(found)));
    if (found != text) state_->file.fail_comparison();
    state_->file.take_place();
}

}  // namespace mscomp

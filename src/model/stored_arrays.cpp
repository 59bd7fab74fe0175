// SPDX-License-Identifier: MIT
#include "mscomp/model/stored_arrays.h"

#include <fmt/format.h>

#include "mscomp/base/error.h"
#include "mscomp/base/finite.h"

namespace mscomp {

void StoredArray::require_finite(const SafetensorsPiece& piece) const {
    if (const auto place = first_non_finite(piece)) {
        throw NumericalError(
            fmt::format("{}: {}{}; nothing was written", path_, piece.name, *place));
    }
}

void StoredArrays::add(const std::string& name, DataType type, Shape shape, Write write) {
    tensors_.push_back({name, type, std::move(shape)});
    writes_.push_back(std::move(write));
}

void StoredArrays::write(const std::string& path, const Metadata& metadata) const {
    SafetensorsPieceWriter to(path, tensors_, metadata);
    for (std::size_t i = 0; i < writes_.size(); ++i) {
        StoredArray array(path, tensors_[i], to);
        writes_[i](array);
    }
    to.finish();
}

}  // namespace mscomp

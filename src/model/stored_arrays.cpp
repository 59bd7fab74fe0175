// SPDX-License-Identifier: MIT
#include "mscomp/model/stored_arrays.h"

namespace mscomp {

void StoredArrays::add(const std::string& name, DataType type, Shape shape, Write write) {
    tensors_.push_back({name, type, std::move(shape)});
    writes_.push_back(std::move(write));
}

void StoredArrays::write(const std::string& path, const Metadata& metadata) const {
    SafetensorsPieceWriter to(path, tensors_, metadata);
    for (const Write& each : writes_) each(to);
    to.finish();
}

}  // namespace mscomp

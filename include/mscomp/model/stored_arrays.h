// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mscomp/base/safetensors_pieces.h"

namespace mscomp {

/// The arrays of a model file, written one after another.
class StoredArrays {
  public:
    using Write = std::function<void(SafetensorsPieceWriter&)>;

    /// An array that is borrowed until write().
    template <class T>
    void add(const std::string& name, Shape shape, std::span<const T> data) {
        add(name, data_type_of<T>(), std::move(shape),
            [=](SafetensorsPieceWriter& to) { to.write(name, 0, data); });
    }
    /// An array of its own.
    template <class T>
    void keep(const std::string& name, Shape shape, std::vector<T> data) {
        const auto kept = std::make_shared<const std::vector<T>>(std::move(data));
        add(name, data_type_of<T>(), std::move(shape),
            [=](SafetensorsPieceWriter& to) { to.write(name, 0, std::span<const T>(*kept)); });
    }
    /// An array that `write` makes when its turn comes, perhaps piece by piece.
    void add(const std::string& name, DataType type, Shape shape, Write write);

    /// As one atomic, checked step. Throws IoError.
    void write(const std::string& path, const Metadata& metadata) const;

  private:
    std::vector<SafetensorsPieceWriter::Tensor> tensors_;
    std::vector<Write> writes_;
};

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mscomp/base/safetensors_pieces.h"

namespace mscomp {

/// One array of a model file while it is written.
class StoredArray {
  public:
    /// Borrows everything.
    StoredArray(const std::string& path, const SafetensorsPieceWriter::Tensor& tensor,
                SafetensorsPieceWriter& file)
        : path_(path), tensor_(tensor), file_(file) {}

    /// The elements from number `first` on. Throws IoError, and NumericalError for a number that is
    /// not finite: no model file ever holds one.
    template <class T>
    void write(std::int64_t first, std::span<const T> data) {
        require_finite(
            {tensor_.name, data_type_of<T>(), tensor_.shape, first, std::as_bytes(data)});
        file_.write(tensor_.name, first, data);
    }

  private:
    void require_finite(const SafetensorsPiece& piece) const;

    const std::string& path_;
    const SafetensorsPieceWriter::Tensor& tensor_;
    SafetensorsPieceWriter& file_;
};

/// The arrays of a model file, written one after another.
class StoredArrays {
  public:
    using Write = std::function<void(StoredArray&)>;

    /// An array that is borrowed until write().
    template <class T>
    void add(const std::string& name, Shape shape, std::span<const T> data) {
        add(name, data_type_of<T>(), std::move(shape), [=](StoredArray& to) { to.write(0, data); });
    }
    /// An array of its own.
    template <class T>
    void keep(const std::string& name, Shape shape, std::vector<T> data) {
        const auto kept = std::make_shared<const std::vector<T>>(std::move(data));
        add(name, data_type_of<T>(), std::move(shape),
            [=](StoredArray& to) { to.write(0, std::span<const T>(*kept)); });
    }
    /// An array that `write` makes when its turn comes, perhaps piece by piece.
    void add(const std::string& name, DataType type, Shape shape, Write write);

    /// As one atomic, checked step. Throws as StoredArray::write; an earlier file then still
    /// stands.
    void write(const std::string& path, const Metadata& metadata) const;

  private:
    std::vector<SafetensorsPieceWriter::Tensor> tensors_;
    std::vector<Write> writes_;
};

}  // namespace mscomp

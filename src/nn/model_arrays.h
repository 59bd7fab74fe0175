// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/safetensors_pieces.h"
#include "nn/parameter_set.h"
#include "nn/vertex_order.h"

namespace mscomp::nn {

/// Writes the arrays of a model file one after another. They are borrowed until write().
class ModelArrays {
  public:
    template <class T>
    void add(const std::string& name, Shape shape, std::span<const T> data) {
        tensors_.push_back({name, data_type_of<T>(), std::move(shape)});
        writes_.push_back([=](SafetensorsPieceWriter& to) { to.write(name, 0, data); });
    }
    /// An array like a parameter with `extents`, brought from inner to user order when it is
    /// written; what that takes is the memory of one component.
    void add_inner(const std::string& name, const Extents& extents, std::span<const float> inner,
                   const VertexOrder& order);
    /// As one atomic, checked step. Throws IoError.
    void write(const std::string& path, const Metadata& metadata) const;

  private:
    std::vector<SafetensorsPieceWriter::Tensor> tensors_;
    std::vector<std::function<void(SafetensorsPieceWriter&)>> writes_;
};

/// Fills an array like a parameter with `extents` from a file; whether all of it is finite. What is
/// right already is not written, so that zeros that take up no memory stay so. Throws InputError.
bool read_inner(const SafetensorsFile& file, const std::string& name, const Extents& extents,
                const VertexOrder& order, std::span<float> inner);

}  // namespace mscomp::nn

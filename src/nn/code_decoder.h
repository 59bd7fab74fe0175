// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "mscomp/model/shape_model.h"

namespace mscomp::nn {

using DecoderColumn = CodeColumn;  // of scaled features

/// What all codes of a model together decode to: scaled features, vertices in the order of the
/// user. Codes are counted level by level, within a level autoencoder by autoencoder.
class CodeDecoder {
  public:
    virtual ~CodeDecoder() = default;

    virtual int code_count() const = 0;
    virtual int vertex_count() const = 0;
    /// Features (V,9) of `codes` (code_count()), of the outputs of the first `levels` levels, 0
    /// meaning all. Safe to call from several threads.
    virtual std::vector<float> decode(std::span<const float> codes, int levels = 0) const = 0;
    /// Derivatives of decode() in every code. Safe to call from several threads.
    virtual std::vector<DecoderColumn> derivatives(std::span<const float> codes) const = 0;
};

}  // namespace mscomp::nn

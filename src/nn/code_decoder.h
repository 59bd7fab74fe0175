// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

namespace mscomp::nn {

/// How the output of a decoder changes with one code: zero at all vertices but these.
struct DecoderColumn {
    std::vector<int> vertices;  // rising
    std::vector<float> values;  // (vertices,9)
};

/// What all codes of a model together decode to: scaled features, vertices in the order of the
/// user. Codes are counted level by level, within a level autoencoder by autoencoder.
class CodeDecoder {
  public:
    virtual ~CodeDecoder() = default;

    virtual int code_count() const = 0;
    virtual int vertex_count() const = 0;
    /// Features (V,9) of `codes` (code_count()). Safe to call from several threads.
    virtual std::vector<float> decode(std::span<const float> codes) const = 0;
    /// Derivatives of decode() in every code. Safe to call from several threads.
    virtual std::vector<DecoderColumn> derivatives(std::span<const float> codes) const = 0;
};

}  // namespace mscomp::nn

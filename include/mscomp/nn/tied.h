// SPDX-License-Identifier: MIT
#pragma once

namespace mscomp::nn {

/// The convolution of a decoder against that of its encoder: its transpose, so that the decoder is
/// the adjoint of the encoder; equal; or one of its own.
enum class Tied { transpose, same, none };

}  // namespace mscomp::nn

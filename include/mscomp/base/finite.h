// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "mscomp/base/safetensors.h"

namespace mscomp {

/// "[2, 17, 4] is nan" for the first value of a tensor of this shape that is not finite (or, with
/// `may_be_nan`, infinite); `bytes`, aligned or not, are its elements from number `first` on. T is
/// float or double.
template <class T>
std::optional<std::string> first_non_finite(std::span<const std::byte> bytes, std::int64_t first,
                                            const Shape& shape, bool may_be_nan = false);

/// The same for a piece of any type; whole numbers are finite.
std::optional<std::string> first_non_finite(const SafetensorsPiece& piece, bool may_be_nan = false);

}  // namespace mscomp

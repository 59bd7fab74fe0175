// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace mscomp {

/// The characters of a UTF-8 text; each byte that belongs to none becomes U+FFFD.
std::u32string from_utf8(std::string_view text);

/// UTF-8 of these characters; surrogates and numbers beyond U+10FFFF become U+FFFD.
std::string to_utf8(std::u32string_view characters);

}  // namespace mscomp

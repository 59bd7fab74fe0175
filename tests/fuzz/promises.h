// SPDX-License-Identifier: MIT
// What the targets check with.
#pragma once

#include <cstddef>
#include <cstring>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "mscomp/base/error.h"

namespace mscomp::fuzz {

/// A reader did not keep what its header promises; the input that made it so is a finding.
class BrokenPromise : public std::logic_error {
  public:
    using std::logic_error::logic_error;
};

inline void require(bool kept, const char* promise) {
    if (!kept) throw BrokenPromise(promise);
}

inline std::string_view text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}
inline std::span<const std::byte> bytes_of(std::string_view text) {
    return std::as_bytes(std::span<const char>(text.data(), text.size()));
}

/// One line that a terminal can show.
inline void check_shown(std::string_view message) {
    for (const char c : message) {
        const auto code = static_cast<unsigned char>(c);
        require(code >= 0x20 && code != 0x7f, "a refusal has no control characters");
    }
}

/// A refusal begins with the name of the file, perhaps with a part of it: "a.npz[faces]: ...".
inline void check_refusal(const Error& error, const std::string& path) {
    const std::string_view message = error.what();
    require(message.starts_with(path), "a refusal names its file");
    check_shown(message.substr(path.size()));
}

/// What `read()` gives, none where it refuses the input: with a Refusal and nothing else.
template <class Refusal = InputError, class Read>
auto unless_refused(const std::string& path, Read&& read) -> std::optional<decltype(read())> {
    try {
        return read();
    } catch (const Refusal& error) {
        check_refusal(error, path);
        return std::nullopt;
    }
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

}  // namespace mscomp::fuzz

// SPDX-License-Identifier: MIT
// Changes that keep checksums and lengths right; blind ones rarely do, and then nothing behind them
// is reached.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace mscomp::fuzz {

/// `text` with a few of libFuzzer's own changes, at most `most` bytes.
std::string changed(std::string text, std::size_t most);

/// A changed copy of a file, about as libFuzzer would do it; the same for the same `seed` and state
/// of libFuzzer. None where the file is too broken to be taken apart.
using Mutate = std::optional<std::string> (*)(std::string_view file, std::size_t most,
                                              unsigned seed);

/// A safetensors file: header, a metadata entry, data, the shape or the type of a tensor.
std::optional<std::string> changed_tensors(std::string_view file, std::size_t most, unsigned seed);
/// A .npz: name, header or data of an array, which are there.
std::optional<std::string> changed_arrays(std::string_view file, std::size_t most, unsigned seed);

/// For a target by its name; null where libFuzzer's own changes do.
constexpr Mutate mutate_of(std::string_view target) {
    if (target == "safetensors" || target == "model" || target == "supports") {
        return changed_tensors;
    }
    if (target == "npz") return changed_arrays;
    return nullptr;
}

}  // namespace mscomp::fuzz

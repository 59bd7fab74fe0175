// SPDX-License-Identifier: MIT
// One target per kind of input. Any bytes at all are either refused with an InputError that names
// the file, or accepted; then what was read is well-formed, and written again it reads as the same.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace mscomp::fuzz {

void check_obj(std::span<const std::byte> input);
void check_off(std::span<const std::byte> input);
void check_ply(std::span<const std::byte> input);
void check_safetensors(std::span<const std::byte> input);
void check_authors_text(std::span<const std::byte> input);
void check_npy(std::span<const std::byte> input);
void check_zip(std::span<const std::byte> input);

struct Target {
    const char* name;  // of its corpus
    void (*check)(std::span<const std::byte> input);
};
inline constexpr std::array<Target, 7> kTargets{{{"obj", check_obj},
                                                 {"off", check_off},
                                                 {"ply", check_ply},
                                                 {"safetensors", check_safetensors},
                                                 {"authors_text", check_authors_text},
                                                 {"npy", check_npy},
                                                 {"zip", check_zip}}};

/// What libFuzzer calls. Throws BrokenPromise for a finding, such as more than a second of
/// processor time; any other exception is one too.
void run_target(const Target& target, const std::uint8_t* data, std::size_t size);

}  // namespace mscomp::fuzz

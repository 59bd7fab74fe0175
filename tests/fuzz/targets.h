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
void check_npz(std::span<const std::byte> input);
void check_splocs(std::span<const std::byte> input);
void check_config(std::span<const std::byte> input);
void check_sweep(std::span<const std::byte> input);
void check_split(std::span<const std::byte> input);
void check_model(std::span<const std::byte> input);
void check_metrics(std::span<const std::byte> input);
void check_evaluation(std::span<const std::byte> input);
void check_units(std::span<const std::byte> input);
void check_truth(std::span<const std::byte> input);
void check_supports(std::span<const std::byte> input);
void check_handles(std::span<const std::byte> input);
void check_list(std::span<const std::byte> input);

struct Target {
    const char* name;  // of its corpus
    void (*check)(std::span<const std::byte> input);
};
inline constexpr std::array kTargets{
    Target{"obj", check_obj},
    Target{"off", check_off},
    Target{"ply", check_ply},
    Target{"safetensors", check_safetensors},
    Target{"authors_text", check_authors_text},
    Target{"npy", check_npy},
    Target{"zip", check_zip},
    Target{"npz", check_npz},
#ifdef MSCOMP_HAS_HDF5
    Target{"splocs", check_splocs},
#endif
    Target{"config", check_config},
    Target{"sweep", check_sweep},
    Target{"split", check_split},
    Target{"model", check_model},
    Target{"metrics", check_metrics},
    Target{"evaluation", check_evaluation},
    Target{"units", check_units},
    Target{"truth", check_truth},
    Target{"supports", check_supports},
    Target{"handles", check_handles},
    Target{"list", check_list},
};

/// What libFuzzer calls. Throws BrokenPromise for a finding, such as more than a second of
/// processor time; any other exception is one too.
void run_target(const Target& target, const std::uint8_t* data, std::size_t size);

}  // namespace mscomp::fuzz

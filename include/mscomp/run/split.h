// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "mscomp/model/config.h"

namespace mscomp {

/// 0-based shape indices, both ascending, disjoint, together all shapes.
struct Split {
    std::vector<int> train, test;
};

/// Which of `shape_count` shapes train (method §6): `all`; `every`: 0, step, 2 step, ...; `random`:
/// the first `count` of the permutation of CounterRandom(seed, 0); `file`: the indices in `path`,
/// one per line, a relative path counted from `config_folder`.
/// Throws UsageError (more training shapes than shapes), IoError (no such file) or InputError with
/// file and line (no index, out of range, repeated).
Split resolve_split(const SplitConfig& config, int shape_count, const std::string& config_folder);

}  // namespace mscomp

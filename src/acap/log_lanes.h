// SPDX-License-Identifier: MIT
#pragma once

namespace mscomp {

/// Rotations side by side, entry by entry: [entry][lane], entries column by column.
struct LogLanes {
    static constexpr int kLanes = 16;
    alignas(64) double rotation[9][kLanes];   // in
    alignas(64) double logarithm[3][kLanes];  // out
};

/// Principal logarithms of proper rotations, as rotation_log gives them to a few units in the last
/// place: length in [0, π], through the unit quaternion, hence accurate near 0 and near π. Each
/// lane depends on nothing but its own rotation; the same bits from every instruction set.
void rotation_logs(LogLanes& lanes);

}  // namespace mscomp

// SPDX-License-Identifier: MIT
#pragma once

namespace mscomp {

/// Most memory that this process has held at a time, mapped pages of files included, in MiB.
double peak_memory_mib();

}  // namespace mscomp

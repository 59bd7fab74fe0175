// SPDX-License-Identifier: MIT
#pragma once

namespace mscomp {

/// Lets a BLAS that has threads of its own (OpenBLAS) use one: ours run around it already, blocks
/// are too small to be shared, and results must not depend on their number. Without such a BLAS
/// nothing happens. For the whole process; safe to call from several threads. Throws IoError where
/// memory is limited so that OpenBLAS, which would wait for it without end, cannot have its own.
void pin_blas_threads();

}  // namespace mscomp

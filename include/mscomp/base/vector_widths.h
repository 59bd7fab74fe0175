// SPDX-License-Identifier: MIT
#pragma once

// A function marked so is compiled once per vector width, and the widest that the processor has is
// picked when the program starts. Its file must not contract products and sums, so that all give
// the same bits. Sanitizers do not bear functions that are called before they are ready.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(MSCOMP_SANITIZED)
#define MSCOMP_FOR_EACH_VECTOR_WIDTH __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define MSCOMP_FOR_EACH_VECTOR_WIDTH
#endif

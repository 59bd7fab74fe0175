// SPDX-License-Identifier: MIT
#define MSCOMP_ISA isa_avx512
#define MSCOMP_ISA_NAME "avx512"
#define MSCOMP_VECTOR_BYTES 64
#include "spectral_table.h"

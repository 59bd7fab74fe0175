// SPDX-License-Identifier: MIT
#define MSCOMP_ISA isa_avx2
#define MSCOMP_ISA_NAME "avx2"
#define MSCOMP_VECTOR_BYTES 32
#include "spectral_table.h"

// SPDX-License-Identifier: MIT
#define MSCOMP_ISA isa_generic
#define MSCOMP_ISA_NAME "generic"
#define MSCOMP_VECTOR_BYTES 16
#include "spectral_table.h"

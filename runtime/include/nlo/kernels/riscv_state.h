// SPDX-License-Identifier: MIT
// Detects the vectors of a RISC-V target, and lists the registers that assembly with vectors changes.
#pragma once

#include "nlo/kernels/arithmetic.h"

#if defined(__riscv_vector) && !defined(NLO_SCALAR_KERNELS)
#define NLO_RISCV_INTEGERS 1  // int16_riscv.h
#if __riscv_v_elen_fp >= 32
#define NLO_RISCV_VECTORS 1  // riscv_vectors.h
#endif

// GCC 12 does not know vector registers and keeps nothing in them. Neither GCC 12 nor clang 14 knows vl and vtype.
#if defined(__clang__)
#define NLO_RISCV_STATE
#elif __GNUC__ >= 13
#define NLO_RISCV_STATE "vl", "vtype",
#endif
#if defined(NLO_RISCV_STATE)
#define NLO_RISCV_CLOBBERS                                                                                            \
  NLO_RISCV_STATE "v0", "v1", "v2", "v3", "v4", "v5", "v6", "v7", "v8", "v9", "v10", "v11", "v12", "v13", "v14",      \
      "v15", "v16", "v17", "v18", "v19", "v20", "v21", "v22", "v23", "v24", "v25", "v26", "v27", "v28", "v29", "v30", \
      "v31", "memory"
#else
#define NLO_RISCV_CLOBBERS "memory"
#endif
#endif

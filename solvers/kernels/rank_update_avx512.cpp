// SPDX-License-Identifier: BSD-3-Clause
#define MAGIMU_ISA avx512
#define MAGIMU_LANES 8
#include "solvers/kernels/rank_update.inc"

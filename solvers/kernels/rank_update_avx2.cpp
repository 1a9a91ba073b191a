// SPDX-License-Identifier: BSD-3-Clause
#define MAGIMU_ISA avx2
#define MAGIMU_LANES 4
#include "solvers/kernels/rank_update.inc"

// SPDX-License-Identifier: BSD-3-Clause
#define MAGIMU_ISA baseline
#define MAGIMU_LANES 2
#include "solvers/kernels/rank_update.inc"

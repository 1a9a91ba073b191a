// SPDX-License-Identifier: BSD-3-Clause
// A pack knows its own alignment; doubles need none.
#define EIGEN_MAX_STATIC_ALIGN_BYTES 0
#define MAGIMU_ISA avx2
#define MAGIMU_LANES 4
#include "solvers/lanes/lane_sweep.inc"

// SPDX-License-Identifier: BSD-3-Clause
// Memory looks the same whatever the instruction set.
#define EIGEN_MAX_STATIC_ALIGN_BYTES 16
#define MAGIMU_ISA avx2
#define MAGIMU_LANES 4
#include "factors/lane_texts.inc"

// SPDX-License-Identifier: BSD-3-Clause
#include "factors/lane_factors.h"

namespace magimu {

namespace baseline {
template <class F>
LaneText lane_text();
}
namespace avx2 {
template <class F>
LaneText lane_text();
}
namespace avx512 {
template <class F>
LaneText lane_text();
}

template <class F>
LaneText lane_text(Isa isa) {
#ifdef __x86_64__
  if (isa == Isa::kAvx512) return avx512::lane_text<F>();
  if (isa == Isa::kAvx2) return avx2::lane_text<F>();
#endif
  return isa == Isa::kBaseline ? baseline::lane_text<F>() : LaneText{};
}

#define MAGIMU_DEFINE(F) template LaneText lane_text<F>(Isa);
MAGIMU_LANE_FACTORS(MAGIMU_DEFINE)

}  // namespace magimu

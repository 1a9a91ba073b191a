// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/lane_sweep.h"

namespace magimu {

namespace baseline {
lanes::SweepCode sweep_code(int d);
}
namespace avx2 {
lanes::SweepCode sweep_code(int d);
}
namespace avx512 {
lanes::SweepCode sweep_code(int d);
}

lanes::SweepCode lanes::sweep_code(Isa isa, int d) {
#ifdef __x86_64__
  if (isa == Isa::kAvx512) return avx512::sweep_code(d);
  if (isa == Isa::kAvx2) return avx2::sweep_code(d);
#endif
  return isa == Isa::kBaseline ? baseline::sweep_code(d) : SweepCode{};
}

}  // namespace magimu

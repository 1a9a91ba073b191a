// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/lanes/lane_sweep.h"

namespace magimu {

namespace baseline {
lanes::SweepCode sweep_code(int d, EliminationForm form);
}
namespace avx2 {
lanes::SweepCode sweep_code(int d, EliminationForm form);
}
namespace avx512 {
lanes::SweepCode sweep_code(int d, EliminationForm form);
}

lanes::SweepCode lanes::sweep_code(Isa isa, int d, EliminationForm form) {
#ifdef __x86_64__
  if (isa == Isa::kAvx512) return avx512::sweep_code(d, form);
  if (isa == Isa::kAvx2) return avx2::sweep_code(d, form);
#endif
  return isa == Isa::kBaseline ? baseline::sweep_code(d, form) : SweepCode{};
}

}  // namespace magimu

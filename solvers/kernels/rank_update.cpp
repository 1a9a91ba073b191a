// SPDX-License-Identifier: BSD-3-Clause
#include "solvers/kernels/rank_update.h"

namespace magimu {

namespace baseline {
lanes::RankCode rank_code();
}
namespace avx2 {
lanes::RankCode rank_code();
}
namespace avx512 {
lanes::RankCode rank_code();
}

lanes::RankCode lanes::rank_code(Isa isa) {
#ifdef __x86_64__
  if (isa == Isa::kAvx512) return avx512::rank_code();
  if (isa == Isa::kAvx2) return avx2::rank_code();
#endif
  return isa == Isa::kBaseline ? baseline::rank_code() : RankCode{};
}

}  // namespace magimu

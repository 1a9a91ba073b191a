// SPDX-License-Identifier: BSD-3-Clause
// To be dropped where factors/effects/effect.cpp has it.
#include "factors/effects/effect.h"

namespace magimu {
std::string to_string(Channel channel) {
  return channel == Channel::kAcc ? "acc" : channel == Channel::kGyr ? "gyr" : "mag";
}
}  // namespace magimu

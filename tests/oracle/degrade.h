// SPDX-License-Identifier: BSD-3-Clause
// From exact readings to samples: noise, then outliers, quantization, clipping and repeated
// samples, in this order, as far as the effects of this channel ask for them.
#pragma once

#include "tests/oracle/effects.h"

namespace magimu::oracle {

// sigma: of the noise of one sample without effects.
void degrade(std::vector<Eigen::Vector3d>& samples, Channel channel, double sigma,
             const std::vector<Effect>& effects, std::uint64_t seed);

}  // namespace magimu::oracle

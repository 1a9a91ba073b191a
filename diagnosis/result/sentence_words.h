// SPDX-License-Identifier: BSD-3-Clause
// Numbers and names as the sentences of a diagnosis say them. In ASCII: "+-" becomes "±" where
// people read it.
#pragma once

#include <string>

namespace magimu {

// "121.0 +- 1.4": as many figures as the standard deviation leaves standing.
std::string value_and_sigma(double value, double sigma);
// "0.73", "250", "1500": two figures without a power of ten.
std::string two_figures(double value);
// "1 nat", "14 nats".
std::string nats(double value);
// "mag_own_clock" -> "magnetometer own clock"
std::string effect_words(const std::string& effect);

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// Numbers of two bytes (IEEE 754, binary16), as numpy's float16 and ArduPilot's logs hold them.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

namespace magimu {

// NaN for infinities, too: no sensor reads them.
inline double half_float(std::uint16_t bits) {
  const int exponent = bits >> 10 & 31, fraction = bits & 1023;
  const double size = exponent == 0    ? std::ldexp(fraction, -24)
                      : exponent == 31 ? std::numeric_limits<double>::quiet_NaN()
                                       : std::ldexp(1024 + fraction, exponent - 25);
  return (bits & 0x8000U) != 0 ? -size : size;
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// The trembling of a hand in an accelerometer's readings.
#pragma once

#include <cmath>
#include <cstdint>

#include "recording/data/recording.h"
#include "sim/draws/random.h"

namespace magimu::test {

// Even samples. size_mm: of the position, which is forgotten within some hundredths of a second.
inline void add_tremor(Recording& r, std::uint64_t seed, double size_mm) {
  RandomStream random(seed, RandomPurpose::kMotion);
  constexpr double kMemory_s = 0.03;
  const double h = 1.0 / r.acc.rate_hz(), keep = std::exp(-h / kMemory_s);
  Vector3 before = Vector3::Zero(), now = Vector3::Zero();
  for (Vector3& f : r.acc.v) {
    const Vector3 next =
        keep * now + std::sqrt(1.0 - keep * keep) * 1e-3 * size_mm * random.normal3();
    f += (next - 2.0 * now + before) / (h * h);
    before = now;
    now = next;
  }
}

}  // namespace magimu::test

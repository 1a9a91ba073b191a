// SPDX-License-Identifier: BSD-3-Clause
// Samples that repeat the sample before in all three axes: it was lost and filled in, or read
// twice. A coarse quantization also makes repeats by chance: their expected number is allowed for,
// and where it is large nothing is counted.
#pragma once

#include <cstddef>

#include "recording/data/recording.h"

namespace magimu {

// Shares of a magnetometer's samples. Fewer repeats than the first do no harm. From the second on
// they usually come from a slower clock that was resampled, and which samples are right is not
// known.
inline constexpr double kFewRepeats = 0.002, kSomeRepeats = 0.25;

struct Repeats {
  std::size_t seen = 0;
  double expected = 0.0;  // share expected from quantization, for samples that change as these do
  double share = 0.0;     // share seen

  bool beyond_chance() const;
};

Repeats repeats_in(const VectorSeries& series);

// The least change of each axis: the converter's step, or that of the file's decimals.
Vector3 least_steps(const VectorSeries& series);

// Are they made by a coarse converter? Then one axis changes by one step at a time; a sensor that
// is read again before it has measured shows all axes changed once it has.
bool made_by_rounding(const VectorSeries& series);

}  // namespace magimu

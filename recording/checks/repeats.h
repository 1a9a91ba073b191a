// SPDX-License-Identifier: BSD-3-Clause
// Samples that are the one before once more, all three axes: lost on their way and filled in, or
// read twice. A coarse quantization does so by chance: that is allowed for, and where it is common
// nothing is counted.
#pragma once

#include <cstddef>

#include "recording/data/recording.h"

namespace magimu {

// Of a magnetometer's samples: fewer than few do no harm. From some on they are mostly the mark of
// a slower clock that was resampled, and which of them are right is not known.
inline constexpr double kFewRepeats = 0.002, kSomeRepeats = 0.25;

struct Repeats {
  std::size_t seen = 0;
  double expected = 0.0;  // by quantization, of samples that change as these do
  double share = 0.0;     // seen, of the samples counted

  bool beyond_chance() const;
};

Repeats repeats_in(const VectorSeries& series);

// The least change of each axis: the converter's step, or that of the file's decimals.
Vector3 least_steps(const VectorSeries& series);

// Are they made by a coarse converter? Then one axis changes by one step at a time; a sensor that
// is read again before it has measured shows all axes changed once it has.
bool made_by_rounding(const VectorSeries& series);

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// Where a motion starts, stops or is jerked, the rate bends within a sample. The high-passed
// readings (high_pass.h) show that as something that sticks out of the noise, over several
// samples. An outlier is a single sample. Of eleven readings x_k about one that sticks out, less a
// cubic,
//
//   x_k = a delta(k - j)       an outlier, at a sample j, or
//   x_k = a max(0, k - tau)    a bend, at a time tau,
//
// both with an amplitude an axis. The one that leaves the smaller sum of squares is taken, which in
// white noise is the more likely one.
#pragma once

#include <vector>

#include "diagnosis/noise/noise_series.h"

namespace magimu {

// Of each sample: does it stick out, or lie about one that does, because of a bend?
std::vector<char> near_bends(const NoiseSeries& series, const Cleaned& cleaned);

}  // namespace magimu

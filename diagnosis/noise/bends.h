// SPDX-License-Identifier: BSD-3-Clause
// Where a motion starts, stops or is jerked, the rate bends within a sample, and what is faster
// than a hand (high_pass.h) has some of that: it sticks out of the noise, but its neighbours know
// of it. An outlier is a single sample. Of eleven readings x_k about one that sticks out, less a
// cubic,
//
//   x_k = a delta(k - j)       an outlier, at a sample j, or
//   x_k = a max(0, k - tau)    a bend, at a time tau,
//
// both with an amplitude an axis: the one that leaves less is what it was, in white noise the more
// likely one.
#pragma once

#include <vector>

#include "diagnosis/noise/noise_series.h"

namespace magimu {

// Of each sample: does it stick out, or lie about one that does, because of a bend?
std::vector<char> near_bends(const NoiseSeries& series, const Cleaned& cleaned);

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// What a polynomial field model leaves out is no white noise: a coefficient of the next degree
// stays what it is while the array moves through it, so its effect on the model is the same way for
// many steps. The filter for that has the next degree's coefficients as states, as a Gauss-Markov
// process over distance (FieldProcess), and lets the lower degrees change by their exact transport
// alone.
//
// How large, without any tuning: what fits of the next degree to single samples of the recording
// show, less what their noise explains. And it forgets within the array's extent, beyond which the
// model claims nothing.
#pragma once

#include "navigation/array_filter.h"
#include "navigation/array_samples.h"

namespace magimu {

// The process for a filter of order `order` + 1, whose highest degree is the truncated one. Throws
// InputError if the layout does not permit `order`.
FieldProcess truncation_process(const ArraySamples& samples, int order);

// Options with order + 1 and that process in place of the published white noise.
ArrayFilterOptions with_truncation(const ArrayFilterOptions& options, const ArraySamples& samples);

}  // namespace magimu

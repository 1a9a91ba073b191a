// SPDX-License-Identifier: BSD-3-Clause
// What a polynomial field model leaves out is no white noise: a coefficient of the next degree
// stays what it is while the array moves through it, so its effect on the model is the same way for
// many steps. The filter for that has the next degree's coefficients as states, as a Gauss-Markov
// process over distance (FieldProcess), and lets the lower degrees change by their exact transport
// alone.
//
// How large, and for how long, without any tuning: a series of polynomials describes an array's
// readings only while its terms fall off within the array. The next degree is given as much as it
// could have at that limit, (size of the model's highest degree) / (radius of the array); and it
// forgets within the array's extent, beyond which the model claims nothing. Both err on the side of
// caution: on the given recordings the coefficients are about a quarter of that.
#pragma once

#include "navigation/array_filter.h"
#include "navigation/array_samples.h"

namespace magimu {

// For a filter of order `order` + 1, whose highest degree is the truncated one. InputError where
// the layout does not permit `order`.
FieldProcess truncation_process(const ArraySamples& samples, int order);

// Options with order + 1 and that process in place of the published white noise.
ArrayFilterOptions with_truncation(const ArrayFilterOptions& options, const ArraySamples& samples);

}  // namespace magimu

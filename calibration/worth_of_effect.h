// SPDX-License-Identifier: BSD-3-Clause
// How much more probable further effects make the readings, by what the residuals show of
// themselves: errors that persist let any slow effect gain, as white noise would count it.
#pragma once

#include "calibration/calibrate.h"
#include "calibration/fit/stage.h"

namespace magimu {

// Nats. `with`: a fit whose effects from `first` on are weighed. gain: by how much its marginal
// likelihood (Laplace; the effects' priors are in it) exceeds that of the fit without them, both at
// their optimum with the same noise. The quadratic part of it, theta' V^-1 theta / 2, is taken with
// the robust covariance (fit/uncertainty.h) in place of the model's, where that is wider. Throws
// NumericalError as summarize_parameters() does.
double worth_of_effects(const std::vector<const Recording*>& recordings, const Stage& with,
                        std::size_t first, double gain, const CalibrationOptions& options);

}  // namespace magimu

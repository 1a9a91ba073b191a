// SPDX-License-Identifier: BSD-3-Clause
// How much more probable one more effect makes the readings, by what the residuals show of
// themselves: errors that persist let any slow effect gain, as white noise would count it.
#pragma once

#include "calibration/calibrate.h"
#include "calibration/fit/stage.h"

namespace magimu {

// Nats. `with` has one effect more than `without`, the last one, both at their optimum with the
// same noise. The marginal likelihoods' ratio (Laplace; the effect's prior is in it), its quadratic
// part theta' V^-1 theta / 2 taken with the robust covariance (fit/uncertainty.h) in place of the
// model's, where that is wider. Throws NumericalError as summarize_parameters() does.
double worth_of_last_effect(const std::vector<const Recording*>& recordings, const Stage& without,
                            const Stage& with, const CalibrationOptions& options);

}  // namespace magimu

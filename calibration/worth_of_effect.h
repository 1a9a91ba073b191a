// SPDX-License-Identifier: BSD-3-Clause
// How much more probable further effects make the readings. White noise would count too much:
// where errors persist, any slow effect gains. So the worth counts the scatter that the residuals
// themselves show.
#pragma once

#include "calibration/calibrate.h"
#include "calibration/fit/stage.h"

namespace magimu {

// Returns nats. `with`: a fit; its effects from number `first` on are weighed. gain: by how many
// nats its log marginal likelihood (Laplace; the effects' priors are in it) exceeds that of the fit
// without them, both at their optimum with the same noise. The quadratic part of the gain,
// theta' V^-1 theta / 2, is taken with the robust covariance (fit/uncertainty.h) in place of the
// model's where the robust one is wider. Throws NumericalError as summarize_parameters() does.
double worth_of_effects(const std::vector<const Recording*>& recordings, const Stage& with,
                        std::size_t first, double gain, const CalibrationOptions& options);

}  // namespace magimu

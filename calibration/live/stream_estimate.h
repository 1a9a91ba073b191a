// SPDX-License-Identifier: BSD-3-Clause
// The calibration that a stream's estimator holds at a moment, read off the root: parameters,
// covariance, field, strength, and the same verdict that batch calibration gives, as far as it can
// be told without going through all samples again.
#pragma once

#include "calibration/result/calibration.h"
#include "solvers/tree/incremental_qr.h"

namespace magimu {

// last: of the same stream, from the last fit of all windows (summary.h): what it says of noise,
// residuals, and how much wider than the model's its robust covariance is, holds on; last_s: how
// long the stream was then. least_widening: of the covariance over the model's, on the whole, by
// what windows since then have shown (WindowConsistency::overdispersion): a fit of a rest and a few
// seconds of motion knows nothing of errors that come with motion.
// Throws std::domain_error, with the direction in words, where a parameter is undetermined.
Calibration stream_estimate(const IncrementalQr& estimator, const ModelSpec& spec,
                            const Calibration& last, double last_s, double least_widening);

// Standard deviation of the heading that the corrected magnetometer gives at the worst attitude,
// degrees, from the covariance in c.
double heading_sigma_deg(const Calibration& c);

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// How large a hidden effect is, in one unit for all: 2 x the Kullback-Leibler divergence of the
// recording's distribution from the nearest one that the model without the effect can give,
//
//   size^2 = 2 min over trajectory and calibration of KL(with the effect | without).
//
// It is the mean gain in twice the log-likelihood that the right model brings before it pays for
// its parameters. For an effect that is linear in theta it is theta' A theta, A the effect's
// efficient information with trajectory and calibration eliminated, and the score statistic is a
// non-central chi-square with this non-centrality.
//
// Readings are shifted: the exact recording (no noise) with the effect is calibrated without it,
// the noise densities given; size^2 is twice the cost that remains, less that without the effect.
// That is theta' A theta, since the eliminated minimum of |J theta - J_x x|^2 is what A means; and
// it holds where theta enters otherwise: clipping, a dipole's place, a random walk's own path.
//
// Noise is changed, N samples of three axes, the residuals all noise:
//   noise_scale       s^2 - 1 - 2 log s for each of the 3 N numbers
//   correlated_noise  -log(1 - rho^2) each: of AR(1) noise of the same variance
//   mag_quantization  as noise_scale with s^2 = 1 + q^2 / (12 sigma^2): rounding adds so much
//                     variance. (That readings are multiples of q shows at any size.)
//   outliers          2 KL of the mixture (1 - eps) N(0, I) + eps N(0, (1 + K^2) I) from the one
//                     normal that is nearest, N(0, (1 + eps K^2) I), by quadrature, each sample;
//                     K is scaled, eps stays
//   acc_tapping       as outliers, what 15 ms of each blow add to the samples they hit
//   mag_time_jitter   3 N log(1 + mean r / 3) - sum log(1 + r_k), r_k = j^2 |dm/dt|^2 / sigma^2:
//                     variance along the field's change, from noise of one size
//   linear_acceleration  its size counts many unknowns: a motion in a band of frequencies has
//                     B = 3 x 2 x band x time coefficients. With r = sum |a|^2 / sigma^2 / B
//                     (what the rotation model leaves, measured as above), B (r - log(1 + r)).
#pragma once

#include <vector>

#include "bench/power/hidden_cases.h"

namespace magimu {

// The case with its one effect (or each of two) as drawn, its size and bias measured.
HiddenCase measured(HiddenCase hidden_case);

// The case once for every size asked for: 0 leaves the realistic strength.
std::vector<HiddenCase> with_sizes(const HiddenCase& hidden_case, const std::vector<double>& sizes);

// Each of a pair's effects alone has this size.
HiddenCase pair_with_size(HiddenCase hidden_case, double size);

}  // namespace magimu

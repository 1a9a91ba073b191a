// SPDX-License-Identifier: BSD-3-Clause
// How well a fitted model predicts another recording of the same device: -log p(y | model), the
// new trajectory integrated out (Laplace),
//
//   log det N + 1/2 |whitened residuals|^2 + 1/2 log det(trajectory's information)
//
// at the trajectory's optimum, N the root of the noise's covariance (log_noise in
// diagnosis/held/log_noise.h). What belongs to the device is held as it was found: biases,
// distortion, lag, scale, sensitivities, temperature coefficients, nonlinearities, densities of the
// noise. What belongs to one recording has a prior and is integrated out as well:
//
//   dip                    almost free, for every model
//   gyroscope's bias       held; where the model has it drift, about the old value with the drift's
//                          own size over the recording
//   hard_iron_change, drifts, field gradients, passing sources, mains: may be there again or not
//                          (even odds); where they are, about as large as they were. The times of a
//                          change are searched for anew, which costs the logarithm of the choice.
//   noise of single samples (outliers, colour, steps, clipping): its parameters from one half of
//                          the new recording, judged on the other, and the other way round
//
// The distortion carries the field's strength: a recording at another place has another one.
#pragma once

#include "calibration/fit/stage.h"
#include "diagnosis/result/diagnosis.h"

namespace magimu {

// The model of a fitted stage without its recordings and nodes, with those of the findings that are
// about the noise of single samples.
ExtendedModel extended_model(const Stage& stage, const std::vector<Finding>& findings);

// Negative log-likelihoods in nats, up to one constant for both.
struct PredictionGain {
  double before = 0.0, after = 0.0;
  bool mag_only = false;
};

// Where the two models differ in the motion they allow, accelerometer and gyroscope enter them in
// ways that cannot be compared, and both are -log p(mag | acc, gyr, model). Throws InputError where
// the recording has too little in it.
PredictionGain compare_predictions(const Recording& recording, const ExtendedModel& before,
                                   const ExtendedModel& after);

}  // namespace magimu

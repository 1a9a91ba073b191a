// SPDX-License-Identifier: BSD-3-Clause
// A model fitted anew to one recording, all its parameters free: the trajectory, parameters and
// densities with which a simulation becomes a replica of the recording, what the model would have
// measured (`magimu simulate --like`).
#pragma once

#include <memory>
#include <vector>

#include "calibration/calibrate.h"
#include "factors/effects/effect.h"
#include "recording/data/recording.h"

namespace magimu {

// An effect of the model, and where its parameters start.
struct ModelTerm {
  std::shared_ptr<const Effect> effect;
  VectorXd start;
};

// The basic model (options.motion; kAuto chooses as calibrate() does) and these terms, with the
// model's covariance alone and no checks. Throws InputError if the model or one of its terms cannot
// be fitted.
Calibration refit_model(const Recording& recording, const std::vector<ModelTerm>& terms,
                        const CalibrationOptions& options);

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// A stage's result as a Calibration: parameters, trajectory, residuals, uncertainty.
#pragma once

#include "calibration/fit/optimum.h"
#include "calibration/result/calibration.h"
#include "calibration/result/calibration_options.h"

namespace magimu {

// Everything that one fit tells. Checks and verdict, which need further fits, are left open.
Calibration summarize(const std::vector<const Recording*>& recordings, const Stage& stage,
                      const CalibrationOptions& options);
Calibration summarize(const std::vector<const Recording*>& recordings, const Optimum& at,
                      const CalibrationOptions& options);
// The parameters and their uncertainty only: nothing of the residuals.
Calibration summarize_parameters(const std::vector<const Recording*>& recordings, const Optimum& at,
                                 const CalibrationOptions& options);
// The parameters with the model's covariance in both places (covariance, covariance_model): for
// methods that have no robust one.
Calibration summarize_model(const std::vector<const Recording*>& recordings, const Stage& stage,
                            const CalibrationOptions& options);
// Residuals by sensor, of a calibration whose noise is known.
void fill_residuals(Calibration& c, const std::vector<NodePlan>& plans, const SensorSums& sums);

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// The two rivals of Huang et al. 2025 on anybody's recording: maximum likelihood of Kok and Schoen
// (kok_scoring.h) and the filter of Wu et al. (wu_filter.h), with the same checks of the samples,
// the same first guess and the same verdict as calibrate(), as far as these methods can say.
#pragma once

#include "calibration/calibrate.h"

namespace magimu {

enum class RivalMethod { kKok, kWu };
std::string to_string(RivalMethod method);

struct RivalOptions {
  RivalMethod method = RivalMethod::kKok;
  // As the code published with Huang et al. 2025 runs it, not as its own publication states it.
  bool as_published = false;
  // Kok as published: the first orientation is held to be the identity, as in that simulation
  // study (sigma 1 mrad), not estimated first (sigma 10 mrad).
  bool start_at_identity = false;
  // Kok as published: evaluations of the objective a parameter; 0: no limit.
  int evaluations_per_parameter = 100;
};

struct RivalCalibration {
  Calibration calibration;
  std::string method;                      // "kok", "wu", "kok, as published", "wu, as published"
  std::vector<std::string> not_estimated;  // sentences: what map estimates and this does not
  // Of the processor, for the method alone: from samples in memory to parameters with covariance.
  double seconds = 0.0;
  long filter_runs = 0;
};

// options: motion must be kRotation or kAuto; where noise is not given it is that at rest, or
// usual. Throws InputError as calibrate() does, and where the published filter of Wu is given
// several recordings; NumericalError where numbers are not finite.
RivalCalibration calibrate_by(const RivalOptions& rival,
                              const std::vector<const Recording*>& recordings,
                              const CalibrationOptions& options = {});

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// The likelihood of a recording that selection and fit never saw.
#include "bench/power/power_study.h"
#include "diagnosis/compare/predict.h"

namespace magimu {

void measure_second_recording(const HiddenCase& c, const Diagnosis& d, PowerOutcome& out) {
  const Recording other = oracle::simulate(second_recording(c)).recording;
  // The motion's own gain would hide what the effect brings.
  const bool motion = c.hidden.front() == "linear_acceleration";
  const PredictionGain gain =
      compare_predictions(other, motion ? d.model_before : d.model_motion, d.model_after);
  out.second_before = gain.before;
  out.second_after = gain.after;
}

}  // namespace magimu

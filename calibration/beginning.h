// SPDX-License-Identifier: BSD-3-Clause
// The fit with few nodes from which all else of a calibration begins, and the recordings as it
// takes them: the accelerometer's samples at the times at which it read what they show. The model
// has a lag of the accelerometer as its rate of change; a hand's force bends within one of some
// milliseconds, and so the samples are put where the fit says that they belong, and fitted anew.
#pragma once

#include <deque>
#include <memory>

#include "calibration/array_fit.h"
#include "calibration/condensed_recording.h"
#include "calibration/pipeline.h"

namespace magimu {

class Beginning {
 public:
  // Throws NumericalError where there is no fit. The recordings must outlive this.
  Beginning(const std::vector<const Recording*>& all, const CalibrationOptions& options);
  Beginning(const Beginning&) = delete;
  Beginning& operator=(const Beginning&) = delete;

  const std::vector<const Recording*>& recordings() const { return fit_->recordings; }
  const FewMagnetometers& few() const { return fit_->few; }  // of them
  const Pipeline& pipeline() const { return fit_->pipeline; }
  const Stage& coarse() const { return fit_->coarse; }
  const std::string& motion_reason() const { return fit_->motion_reason; }

  // The lag that the recordings' times have in them and the model has not, in the parameters of a
  // calibration: all of it.
  void add_lag(Calibration& c) const;
  void add_lag(CondensedRecording& condensed) const;

 private:
  struct Fit {
    Fit(const std::vector<const Recording*>& given, double acc_late_s,
        const CalibrationOptions& options);

    std::deque<Recording> copies;
    std::vector<const Recording*> recordings;
    FewMagnetometers few;
    Pipeline pipeline;
    std::string motion_reason;
    Stage coarse;
  };

  double late_s_ = 0.0;
  std::unique_ptr<Fit> fit_;
};

}  // namespace magimu

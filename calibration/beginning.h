// SPDX-License-Identifier: BSD-3-Clause
// The fit with few nodes from which all else of a calibration begins, and the recordings as it
// takes them: the accelerometer's samples at the times at which it read what they show. Most
// gyroscopes give the mean rate of the interval before a sample's time, and filters have delays:
// what a swung accelerometer reads then belongs to another attitude, and omega x f tau has a mean.
// A hand's motion takes up what the readings are wrong by, and the bias that mean, so that
// residuals need not show it: what is not known of the lag counts in the sigmas.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>

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

  // What is not known of the lag, in both covariances of a calibration of these recordings; and in
  // what is said of its recording to others.
  void add_doubt(Calibration& c, CondensedRecording* condensed) const;
  // The lag that the recordings' times have no more, last of all.
  void add_lag(Calibration& c) const;

 private:
  struct Fit {
    // known: as in Pipeline::coarse().
    Fit(const std::vector<const Recording*>& given, double acc_late_s,
        const CalibrationOptions& options, const std::vector<std::string>& known = {});

    std::deque<Recording> copies;
    std::vector<const Recording*> recordings;
    FewMagnetometers few;
    Pipeline pipeline;
    std::string motion_reason;
    Stage coarse;
  };
  // Of the accelerometer against the gyroscope, beside a fit: what it is, how sure that is (by the
  // model, and where residuals are not white), and by how much a second of it moves the parameters,
  // in order and units of Calibration::order.
  struct Lag {
    double tau_s = 0.0, sigma_s = 0.0, robust_s = 0.0;
    VectorXd moves;
  };
  static std::optional<Lag> lag_of(const Fit& fit, const CalibrationOptions& options);

  double late_s_ = 0.0;
  std::unique_ptr<Fit> fit_;
  std::optional<Lag> lag_;
};

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// What a recording can tell, before anything is fitted to it: its sensors, rests and noise, the
// checks of recording/checks/quality.h, whether the axes agree, the orientations it went through,
// and how well a calibration would know each parameter. The last is a linearized
// maximum-a-posteriori estimate without an iteration: the model's information at the first guess,
// which depends on the motion far more than on the parameters.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "calibration/calibrate.h"
#include "calibration/motion/rests/rests.h"
#include "calibration/start/turned_axes.h"
#include "calibration/survey/coverage.h"
#include "calibration/trust/mounting.h"
#include "recording/checks/quality.h"

namespace magimu {

struct SensorSurvey {
  std::string name;
  std::size_t samples = 0;
  double rate_hz = 0.0, longest_interval_s = 0.0;
  double largest = 0.0;        // absolute reading of any axis, in the sensor's unit
  double noise_density = 0.0;  // at rest, per sqrt(Hz); 0: no rests
};

struct ExpectedParameter {
  std::string name;  // as in a calibration's covariance: parameter_names.h
  double sigma = 0.0;
};

struct Survey {
  std::string recording;
  double begin_s = 0.0, duration_s = 0.0;
  std::vector<SensorSurvey> sensors;  // accelerometer, gyroscope, magnetometers
  std::vector<TimeSpan> rests;
  std::optional<Vector3> gyr_bias_at_rest;
  std::vector<Issue> issues;

  // Below: only where nothing fatal was found and the recording is long enough to begin with.
  std::string not_looked_further;  // else why; empty: all of it is there
  Mounting mounting;
  Coverage coverage;
  TurnedAxes turned;
  Matrix3 distortion = Matrix3::Identity();  // of the first magnetometer, roughly

  double dip_rad = 0.0, strength_uT = 0.0;  // roughly
  int dip_sign = 0;                         // of the true dip, where it is known (calibrate.h)
  double ellipsoid_rms_uT = 0.0;  // how far the magnetometer's readings are from one ellipsoid
  MotionModel motion = MotionModel::kHandHeld;
  NoiseDensities noise;  // assumed
  std::vector<ExpectedParameter> expected;
  double expected_strength_sigma = 0.0;   // of D's columns, root mean square, as a share of it
  std::vector<std::string> undetermined;  // combinations of parameters, in words

  // Too little to tell the magnetometer's bias from the field: what is expected below is then what
  // an ideal sensor would give, and the guess of the field may be far off.
  bool hardly_turned() const;
  // The readings of a turning magnetometer lie on an ellipsoid, unless something magnetic comes
  // near or the field differs from place to place.
  bool disturbed() const;
  // Nothing stands against calibrating this recording.
  bool usable() const;
  // The gravest fault of its samples that a calibration would suffer from; null: none.
  const Issue* worst_fault() const;
  double sigma(const std::string& name) const;
};

struct SurveyOptions {
  std::optional<NoiseDensities> noise;  // default: at rest
  double gravity = kStandardGravity;
  MotionModel motion = MotionModel::kHandHeld;  // kAuto: kHandHeld, which claims less
  int dip_sign = 0;                             // of the true dip; 0: unknown (calibrate.h)
  std::function<void(const std::string& what, double share)> progress;
};

Survey survey(const Recording& recording, const SurveyOptions& options = {});

}  // namespace magimu

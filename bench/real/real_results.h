// SPDX-License-Identifier: BSD-3-Clause
// What calibration makes of a real recording that carries an optical truth (BROAD): orientation
// errors (as delivered: no alignment of the two frames to each other), a calibration applied to
// another recording of the sensor, and whether separate calibrations of one sensor agree as well as
// they say.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "calibration/calibrate.h"
#include "calibration/trust/orientation_error.h"
#include "recording/data/recording.h"

namespace magimu {

// What a total error consists of, in deg RMS: what remains after the clock of the truth is shifted,
// and what after a constant turn of both the reference frame and the sensor's, too.
struct ErrorParts {
  double delivered_deg = 0.0;
  double shift_ms = 0.0;  // the estimate that much later matches the truth best
  double shifted_deg = 0.0;
  double aligned_deg = 0.0;
};
ErrorParts error_parts(const Recording& recording, const Calibration& calibration);

struct RealResult {
  Recording recording;
  Calibration rotation;  // the paper's model: the sensor only turns
  Calibration ours;      // by default, the model of the motion chosen from the data
  // Total, heading, inclination: zeros where the recording has no truth.
  OrientationError uncalibrated;                  // the fixed filter on readings as they are
  OrientationError rotation_error, ours_error;    // the calibrations' own trajectories
  OrientationError rotation_filter, ours_filter;  // the fixed filter with the calibrations
  TrajectoryEstimate uncalibrated_trajectory;
  ErrorParts parts;  // of ours_error

  std::string number() const;  // "02"
  std::string name() const;    // "slow rotation"
};

RealResult evaluate(Recording recording);
// The orientation error of the fixed filter with this calibration.
OrientationError filter_error(const Recording& recording, const Calibration& calibration);

// A calibration of one recording used for another.
struct CrossApplication {
  std::string calibrated, applied;  // numbers
  double own_deg, other_deg, uncalibrated_deg;
};
CrossApplication cross_apply(const RealResult& calibrated, const RealResult& applied);

// Differences of separate calibrations of one sensor, in units of their reported standard
// deviations, RMS over elements and pairs. D is compared as D / cbrt(det D), because the strength
// of the field differs from place to place.
struct Repeatability {
  double acc_bias = 0.0, mag_bias = 0.0, distortion = 0.0, all = 0.0;
  std::array<std::array<double, 2>, 3> difference{};  // of o_a, o_m, D: RMS, and of its sigma
};
Repeatability repeatability(const std::vector<const Calibration*>& calibrations);

// D / cbrt(det D), column by column, with its covariance (9 x 9, of rank 8).
struct NormalizedDistortion {
  VectorXd value;
  MatrixXd covariance;
};
NormalizedDistortion normalized_distortion(const Calibration& calibration);

// Numbers over time in at most `points` equal steps, not a number where there are none.
struct TimeSeries {
  std::vector<double> t;
  std::vector<double> value;
};
// RMS of the total orientation error, deg.
TimeSeries error_over_time(const TrajectoryEstimate& estimate, const MotionTruth& truth,
                           int points);
// Mean of one axis of magnetometer 0's residual, reading minus model, uT.
std::array<TimeSeries, 3> mag_residual_over_time(const Recording& recording,
                                                 const Calibration& calibration, int points);

}  // namespace magimu

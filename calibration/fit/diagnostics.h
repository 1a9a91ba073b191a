// SPDX-License-Identifier: BSD-3-Clause
// Has the estimate converged, and do the data bear it out? A handful of checks, each with a status
// and a sentence, that batch calibration, streaming and reports share. They describe; what follows
// from them for the verdict is trust.h's business.
#pragma once

#include "calibration/fit/held_out.h"
#include "calibration/result/calibration.h"

namespace magimu {

// Gradient and last step of the optimization, in standard deviations of the estimate.
Check check_optimum(const Result& fit);

// Did the field come within 20 degrees of this direction of the sensor (IMU frame)? false, too,
// where c has no trajectories.
bool field_came_near(const Calibration& c, const Vector3& direction);

// Standard deviation of the corrected field's direction, D^-1 (mag - o_m), at the worst of all
// directions of the field in the IMU frame. Of one magnetometer, by default the first.
Check check_accuracy(const Calibration& c, std::size_t magnetometer = 0);

// Correlation of neighbouring magnetometer residuals; what it means for the sigmas.
Check check_whiteness(const Calibration& c);

// Normalized innovation squared of the magnetometer, window by window of some seconds: squares
// (Stage::mag_squares) against their mean.
Check check_windows(const Calibration& c, const std::vector<double>& mag_squares);

// Magnetometer left out in every other block of seconds and predicted from the rest, as a share of
// the field's strength. (How much worse than fitted ones depends on the gyroscope, which alone
// leads through the block.)
Check check_held_out(const BlockErrors& errors, double strength_uT);

// First half against second: distortion and bias of the magnetometers, each half calibrated by
// itself, by the uncertainty both report. value: root mean square in sigmas, 1 if both are right;
// of an array also of each magnetometer.
Check check_halves(const Calibration& first, const Calibration& second);
// The same of whole recordings, each calibrated by itself, if it could be: the two that lie
// farthest apart. Nothing where fewer than two could.
std::optional<Check> check_recordings(const std::vector<std::optional<Calibration>>& each,
                                      const std::vector<std::string>& names);

// How a value of that check, in sigmas, is graded.
CheckStatus grade_halves(double rms);

}  // namespace magimu

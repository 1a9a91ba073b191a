// SPDX-License-Identifier: BSD-3-Clause
// The use of a calibration: a recording, corrected, in the axes of the IMU.
//
//   acc_cal = acc - o_a        gyr_cal = gyr - o_w        mag_cal = s D^-1 (mag - o_m)
//
// s is the field's strength, so that mag_cal is in uT (mag_cal / s is the unit field). Effects of
// the calibration are taken out as well where their inverse is exact for any recording: what a
// sensor adds to its own reading is found by iteration, a lag by moving the magnetometer's times.
// What belongs to the recording it was found in (a drift, a magnet that came near) stays, and is
// named.
#pragma once

#include <string>
#include <vector>

#include "calibration/result/calibration.h"
#include "recording/data/recording.h"

namespace magimu {

struct ApplyOptions {
  // A lag is taken out by stamping magnetometer samples earlier; with false they keep their times.
  bool move_mag_times = true;
};

struct Applied {
  Recording recording;
  std::vector<std::string> formulas;     // what was done, with its numbers
  std::vector<std::string> not_applied;  // effects that are left in the data, and why
  std::vector<std::string> doubts;  // why it may be no recording of this device (apply_doubts.h)
};

// Throws InputError where the calibration was never made (a Calibration as its constructor leaves
// it).
void require_complete(const Calibration& calibration);

// Look at Calibration::trust first: with the verdict `no` parameters may be placeholders.
// InputError where the calibration is empty, the recording has another number of magnetometers than
// the calibration, lacks a column that one of its effects needs, or where its magnetometer has
// another unit.
Applied apply(const Calibration& calibration, const Recording& recording,
              const ApplyOptions& options = {});

// s D^-1 of one magnetometer, dimensionless: what is left of distortion, misalignment and gain.
Matrix3 mag_correction(const Calibration& calibration, std::size_t magnetometer);
// s D^-1 (mag - o_m), uT: the basic formula without effects.
Vector3 corrected_mag(const Calibration& calibration, std::size_t magnetometer,
                      const Vector3& mag_uT);
// (I + S)^-1 (gyr - o_w), S the gyroscope's scale errors and misalignment where they are part of
// the calibration.
Vector3 corrected_gyr(const Calibration& calibration, const Vector3& gyr);
// (I + S)^-1 of the above, and (I + L)^-1 of the accelerometer's: f = (I + L)^-1 (acc - o_a).
Matrix3 gyr_correction(const Calibration& calibration);
Matrix3 acc_correction(const Calibration& calibration);
// S of the above; zero where the calibration has none.
Matrix3 gyr_scale_misalignment(const Calibration& calibration);
// L of acc = (I + L) f + o_a, lower triangular; zero where the calibration has none.
Matrix3 acc_scale_misalignment(const Calibration& calibration);
// How long the magnetometer lags, s; 0 where the calibration has no lag.
double mag_lag_s(const Calibration& calibration, std::size_t magnetometer);

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// What should the person who holds the sensor do next? Each of a handful of motions that one can
// say in a sentence is played through: what the magnetometer and the accelerometer would read on
// the way, from the present attitude, as information about the calibration,
//
//   A' = A + sum_k J_k' S^-1 J_k      A: information of the last attitude and the globals so far
//
// and the motion is named in which the target is reached first; where none does, the one after
// which the target's standard deviation has fallen most for the time it takes. The gyroscope is
// taken for good enough to know the attitude relative to the present one, up to its bias; J_k is of
// the measurement models of factors/sensor_model.h.
#pragma once

#include <string>
#include <vector>

#include "calibration/live/streaming.h"
#include "solvers/tree/incremental_qr.h"

namespace magimu {

struct Motion {
  std::string sentence;
  std::string missing;             // "turn about x"; empty for diagonals and keeping still
  Vector3 axis = Vector3::Zero();  // in the IMU frame, unit length; zero: keep still
  double angle_rad = 0.0, time_s = 0.0;
  std::string headline;  // two or three words, to be read from two metres: "Turn about X"
  int number = -1;       // of the axis x, y or z: 0, 1, 2; -1: none of these alone
};

// Half turns about the axes and the diagonals between two of them, three quarters about the axes,
// and keeping still. nRb: the present attitude.
std::vector<Motion> motions_from(const Rot3& nRb);

struct Guidance {
  Motion motion;                     // the best
  std::vector<std::string> missing;  // of all motions that would help
  std::string
      which;  // a sentence that shows the axis to the person who holds the board; may be empty

  // The sentence of the motion, and the one that says which axis it is.
  std::string text() const { return motion.sentence + (which.empty() ? "" : " " + which); }
};

// Which axis that is: "X points up now: spin it flat, like a plate on a table, either way round."
// up: the direction upward in the sensor's frame; zero: not known. north, east: likewise, where
// they are known; they tell level axes from each other.
std::string which_axis(const Motion& motion, const Vector3& up,
                       const Vector3& north = Vector3::Zero(),
                       const Vector3& east = Vector3::Zero());

// distance: from a calibration's covariance to how far the target is (1: reached); it is given the
// covariance in the order and units of `now`, which is the estimate so far.
Guidance guide(const IncrementalQr& estimator, const ModelSpec& spec, Key last_attitude,
               const Calibration& now, const std::function<double(const Calibration&)>& distance);

// Before there is an estimate: by how far the sensor has been turned about each axis, rad, and the
// direction upward in its frame. Three quarters of a turn about a level axis and then about one
// that is level after it are nearly enough.
Guidance guide(const Vector3& turned_rad, const Vector3& up, bool rested);

}  // namespace magimu

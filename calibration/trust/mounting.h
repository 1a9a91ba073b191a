// SPDX-License-Identifier: BSD-3-Clause
// Do the sensors' axes agree? A direction that is fixed in space, gravity's or the field's, turns
// in the sensor's frame as the gyroscope says, u' = -omega x u, only where both use the same axes.
// Each of the 48 signed permutations G of the gyroscope's axes is tried: with the right one the
// directions, brought to one frame by the gyroscope, stand still.
//
// A sensor whose readings are Q u fits with G = det(Q) Q, always a rotation: Q and -Q fit alike.
// So no motion can tell a sensor that is turned from one with an odd number of axes inverted, or
// one as it should be from one with all three inverted; the sign of the dip can, where it is known
// (positive on the northern hemisphere). A gyroscope with an odd number of axes inverted fits with
// a G that is no rotation, and is found.
#pragma once

#include <string>
#include <vector>

#include "recording/data/recording.h"

namespace magimu {

// How one sensor's directions turn against the gyroscope.
struct AxesFit {
  std::string sensor;             // "acc", "mag", "mag1", ...
  std::vector<Matrix3> gyr_axes;  // the signed permutations of the gyroscope that fit, best first;
                                  // several: the motion does not tell which; none: nothing fits
  double rms_rad = 0.0;           // of the best: how far the direction wanders from pair to pair
  double rms_straight_rad = 0.0;  // of the axes as they are
  bool straight() const { return gyr_axes.size() == 1 && gyr_axes.front().isIdentity(); }
  bool decided() const { return gyr_axes.size() == 1; }
  bool may_be_straight() const;
};

// A sensor whose axes are not the others'.
struct AxesFinding {
  std::string sensor;
  Matrix3 remedy;            // to be applied to its readings: recording/data/axes.h, --axes
  bool or_inverted = false;  // minus the remedy fits as well
  std::string problem, text_of_remedy;
};

enum class MountingStatus {
  kConsistent,  // all sensors agree
  kTurned,      // some do not: see findings
  kUndecided,   // the motion does not tell, or nothing fits
};

struct Mounting {
  MountingStatus status = MountingStatus::kUndecided;
  std::vector<AxesFit> fits;  // accelerometer first
  std::vector<AxesFinding> findings;
  std::string sentence;  // the whole, for people
};

// Of an undecided mounting what the decided sensors say, where the others may be as they should be,
// or as the decided ones are: for the beginning of a stream. Empty where that leaves a choice.
std::vector<AxesFinding> likely_findings(const Mounting& mounting);

// What the best fit of each sensor says, where others fit about as well.
std::vector<AxesFinding> findings_so_far(const Mounting& mounting);

// The recording must have samples of accelerometer and gyroscope; magnetometers are optional.
Mounting check_mounting(const Recording& recording);

}  // namespace magimu

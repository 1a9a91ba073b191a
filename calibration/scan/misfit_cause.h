// SPDX-License-Identifier: BSD-3-Clause
// What is known of why the magnetometer departs from one homogeneous field, before a magnet or iron
// is blamed: a column of the recording that explains it, single readings that stand out, one line
// in the spectrum.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/result/calibration.h"
#include "calibration/scan/missing_effects.h"

namespace magimu {

// In sentences; empty where nothing is known. A cause counts that explains more than half of the
// squares: then it is the main one, whatever else there is.
std::string cause_of_misfit(const Calibration& c, const std::vector<MissingEffect>& missing);

// Where most of it is one step of the magnetometer's bias, and no other effect explains as much:
// that step.
std::optional<BiasStep> step_of_magnetometer(const SearchedEffects& searched);
// "At about 51 s (to within 5 s) the magnetometer's bias changed for good, by about (0, 0, 2.5) uT:
// a magnet or iron was attached or removed (or it drifted: ...)."; "Between about 51 and 76 s (...)
// was another one".
std::string sentence(const BiasStep& step);

// Of one magnetometer's whitened residuals. Share of the squares in single readings that noise
// makes in one recording of a hundred, and how many they are.
struct OutlyingReadings {
  double share = 0.0;
  std::size_t count = 0;
};
OutlyingReadings outlying_readings(const std::vector<Vector3>& whitened);

// The strongest frequency above those of a hand, Hz, and its share of the squares.
struct StrongestLine {
  double share = 0.0, hz = 0.0;
};
StrongestLine strongest_line(const std::vector<double>& t, const std::vector<Vector3>& whitened);

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// The comparison of navigation filters over many recordings with their truth: which cases, which
// variants, one row of figures each. bench/navigation.cpp prints it; a study of calibrations
// (what is each worth in metres?) calibrates the cases' recordings first.
#pragma once

#include <string>
#include <vector>

#include "navigation/navigation_errors.h"
#include "sim/array_room.h"

namespace magimu {

struct NavigationCase {
  Recording recording;  // of a calibrated array, with its truth
  std::vector<Vector3> positions;
  NavigationStart start;
  double gravity = 9.82;  // m/s^2
  // Of a simulated room: what the magnetometers would read without noise, 3 M x N, uT.
  MatrixXd exact_mag;
};

// The published recordings in a folder (recording/arrays/array_mat.h), in the order of their names;
// those without a truth are left out.
std::vector<NavigationCase> navigation_cases(const std::string& folder);
// The array of sim/array_room.h in a room of dipoles, by its seed; the start is off the truth as
// the filters assume.
// moment: standard deviation of a dipole's components, A m^2.
NavigationCase simulated_case(unsigned seed, double moment = ArrayRoomOptions().moment);

struct NavigationVariant {
  std::string name;
  NavigationOptions options;
  StepReadings readings = StepReadings::kMean;
  bool coloured = false;         // with_truncation() of the case
  bool shrink_gradients = true;  // of the coloured ones (ArrayFilterOptions)
  // The filter's derivatives taken at the true field, where the case knows it: shows what those at
  // the estimated field do to the claims.
  bool at_true_field = false;
};
// The last variant with its derivatives at the true field; for simulated rooms.
NavigationVariant at_true_field_variant();
// Inertial alone; as published; with the steps' readings mended; with the coloured truncation.
std::vector<NavigationVariant> navigation_variants();

struct NavigationStudyRow {
  NavigationSummary summary;
  std::vector<NavigationMetrics> runs;
  double times_real_time = 0.0;  // seconds of the recordings a second of one processor
};
NavigationStudyRow run_variant(const NavigationVariant& variant,
                               const std::vector<NavigationCase>& cases);

}  // namespace magimu

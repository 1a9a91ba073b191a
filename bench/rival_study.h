// SPDX-License-Identifier: BSD-3-Clause
// The paper's simulation study, a method at a time: n data sets at given rates, each calibrated by
// MAP, by Kok or by Wu, in the sound form or as published, with its noise densities given; errors
// against the bound (the MAP's covariance), NEES, and seconds.
#pragma once

#include <optional>

#include "bench/error_statistics.h"
#include "calibration/rival_calibration.h"
#include "sim/simulate.h"

namespace magimu {

enum class StudyMethod { kMap, kKok, kKokPublished, kKokUnlimited, kWu, kWuPublished };
std::string to_string(StudyMethod method);

struct StudyOptions {
  SimulationOptions simulated;  // motion, rate, ratio; the seed is first_seed + index
  int runs = 20, first_seed = 1, threads = 1;
};

struct StudyRun {
  SensorParameters truth;
  Calibration calibration;  // without trajectory and values
  double seconds = 0.0;     // samples in memory to parameters with covariance
  long filter_runs = 0;
  std::string error;  // where there is no calibration
};

// In the order of the seeds, whatever the number of threads.
std::vector<StudyRun> run_study(StudyMethod method, const StudyOptions& options);

// Of all 19 parameters, in standard deviations of b's model: sqrt((a - b)' P^-1 (a - b)), and the
// largest of a single parameter.
struct StudyDistance {
  double joint = 0.0, largest = 0.0;
};
StudyDistance distance(const Calibration& a, const Calibration& b);

// Errors of `runs` against the covariance of `bound` (the MAP's on the same data sets), NEES with
// their own. Runs with an error are left out and counted.
struct StudySummary {
  std::vector<GroupStatistics> groups;
  double nees = 0.0;
  Band nees_band;
  double median_seconds = 0.0;
  int failed = 0, not_converged = 0, most_iterations = 0;
};
StudySummary summarize_study(const std::vector<StudyRun>& runs, const std::vector<StudyRun>& bound,
                             double width);

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// One method of calibration on many simulated data sets, one setting at a time: by the MAP, by Kok
// or by Wu, in the sound form or as published, with the noise densities given; errors against the
// bound (the MAP's covariance), NEES, and seconds.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calibration/rivals/rival_calibration.h"
#include "sim/simulate.h"
#include "statistics/quantiles.h"
#include "study/error_statistics.h"
#include "study/study.h"

namespace magimu {

enum class Method {
  kMap,
  kMapPublishedWeight,  // the gyroscope weighed as the published code does
  kKok,
  kKokPublished,
  kKokUnlimited,  // as published, but for the limit of evaluations
  kWu,
  kWuPublished
};
std::string to_string(Method method);

// What is simulated, and what the calibration is told of it.
struct MethodSetting {
  SimulationOptions simulated;  // motion, rate, ratio, effects; the seed is first_seed + index
  int runs = 20, first_seed = 1;
  bool estimate_mag_time_offset = false;    // by the MAP
  std::optional<Vector3> gyr_bias_error{};  // rad/s, where the MAP starts, off the truth
};

struct MethodRun {
  SensorParameters truth;
  Calibration calibration;  // without trajectory and values
  double seconds = 0.0;     // of the processor: samples in memory to parameters with covariance
  long filter_runs = 0;
  std::string error;  // where there is no calibration
};

// In the order of the seeds, whatever the number of threads.
std::vector<MethodRun> run_method(Method method, const MethodSetting& setting, int threads);

// Calls body(i) for i = 0 .. count - 1, `threads` at a time, each limited to its own thread.
void for_each_data_set(int count, int threads, const std::function<void(int)>& body);

// The same runs for everybody who asks: experiments share many.
class StudyRuns {
 public:
  explicit StudyRuns(int threads) : threads_(threads) {}
  const std::vector<MethodRun>& get(Method method, const MethodSetting& setting);
  int threads() const { return threads_; }

 private:
  int threads_;
  std::map<std::string, std::vector<MethodRun>> runs_;
};

// Of all 19 parameters, in standard deviations of b's model: sqrt((a - b)' P^-1 (a - b)), and the
// largest of a single parameter.
struct MethodDistance {
  double joint = 0.0, largest = 0.0;
};
MethodDistance distance(const Calibration& a, const Calibration& b);

// RMSE of groups of ten data sets drawn from all: what a study of ten data sets, such as the
// published one, may print. 99 % lie within low and high, 99.98 % within least and most.
struct RangeOfTen {
  double low = kNoValue, high = kNoValue, least = kNoValue, most = kNoValue;
};

// Errors of `runs` against the covariance of `bound` (the MAP's on the same data sets), NEES with
// their own. Runs with an error are left out and counted.
struct MethodSummary {
  std::vector<GroupStatistics> groups, wide_groups;  // o_a, o_w, o_m, D, dip: at 99 and 99.99 %
  std::vector<RangeOfTen> ten;                       // of each group
  double nees = kNoValue;
  Band nees_band, wide_nees_band;
  double median_seconds = kNoValue;
  int runs = 0, failed = 0, not_converged = 0, most_iterations = 0;
  // From `bound`'s estimates, of all parameters jointly, standard deviations.
  double median_distance = kNoValue, largest_distance = kNoValue;
  // The same of the single parameter that is furthest off.
  double median_single = kNoValue, largest_single = kNoValue;
};
MethodSummary summarize(const std::vector<MethodRun>& runs, const std::vector<MethodRun>& bound);

}  // namespace magimu

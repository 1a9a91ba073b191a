// SPDX-License-Identifier: BSD-3-Clause
// How far a trajectory is from the truth, and whether its covariance is honest: the metrics of the
// literature on magnetic-field-aided navigation, and those of consistency. NEES: squared error in
// the metric of
// the claimed covariance, on average the number of its coordinates where the claim is right.
#pragma once

#include "navigation/navigate.h"

namespace magimu {

// At one time.
struct NavigationError {
  Vector3 position = Vector3::Zero();  // estimate less truth, m, in n
  double yaw = 0.0;                    // rad, about n's vertical axis
  double position_sigma = 0.0;         // claimed, m: root of the sum of the three variances
  double yaw_sigma = 0.0;              // claimed, rad
  double position_nees = 0.0;          // chi-square with 3 numbers
};
NavigationError navigation_error(const NavigationRun& run, const ArraySamples& samples,
                                 std::size_t k);

// Of one run.
struct NavigationMetrics {
  NavigationError first, last;
  double duration_s = 0.0;
  double distance_m = 0.0, unaided_distance_m = 0.0;  // of the true path
  double final_3d_m = 0.0, final_horizontal_m = 0.0;
  double mean_horizontal_m = 0.0;   // after the aid has ended
  double mean_position_nees = 0.0;  // over all times
  double final_3d_over_distance() const { return final_3d_m / distance_m; }  // of the whole path
  // Of the innovations, per number: of the field's coefficients; of all readings, with the noise
  // taken from this sample's residuals; of the residuals with the noise taken from the sample
  // before (the noise from the sample itself would make that one 1 whatever happens).
  double field_nis = 0.0, all_nis = 0.0, residual_nis = 0.0;
};
// Needs the truth.
NavigationMetrics navigation_metrics(const NavigationRun& run, const ArraySamples& samples,
                                     double aided_s = 0.0);

// Of several runs, at the end of each.
struct NavigationSummary {
  int runs = 0;
  double position_rmse = 0.0, position_sigma = 0.0;                  // m; claimed: root mean square
  double yaw_rmse = 0.0, yaw_sigma = 0.0, yaw_sigma_at_start = 0.0;  // rad
  double position_nees = 0.0, position_nees_throughout = 0.0;        // per coordinate, mean
  double field_nis = 0.0, all_nis = 0.0, residual_nis = 0.0;         // mean
  double median_final_over_distance = 0.0;
};
NavigationSummary summarize(const std::vector<NavigationMetrics>& runs);

}  // namespace magimu

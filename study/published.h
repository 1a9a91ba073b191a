// SPDX-License-Identifier: BSD-3-Clause
// Numbers of Huang et al. 2025: of its text where only that has them, else what the code published
// with it gives, which its figures show. RMSE over ten data sets, seconds for all ten (Kok on 20
// processors). They stand beside ours and are nobody's target: each is one draw of ten.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "study/method_runs.h"

namespace magimu {

// o_a m/s^2, o_w rad/s, o_m uT, D uT.
using PublishedRmse = std::array<double, 4>;
inline constexpr std::array<double, 4> kPublishedRates{10.0, 20.0, 40.0, 80.0};  // Hz
inline constexpr std::array<int, 4> kPublishedRatios{1, 2, 4, 8};                // at 80 Hz

// Nothing for what was not published.
std::optional<PublishedRmse> published_rate_rmse(Method method, double rate_hz);
std::optional<PublishedRmse> published_ratio_rmse(Method method, int ratio);
// Of one data set; kNoValue where there is none.
double published_rate_seconds(Method method, double rate_hz);
double published_ratio_seconds(Method method, int ratio);

// Table III: of the MAP at 80 Hz, the magnetometer late by -12.5, 0, 12.5 ms.
inline constexpr std::array<double, 3> kPublishedDelays{-0.0125, 0.0, 0.0125};  // s
std::optional<PublishedRmse> published_delay_rmse(double delay_s);
// Half a unit of the last digit printed there.
inline constexpr PublishedRmse kPublishedDelayRounding{5e-5, 5e-7, 5e-5, 5e-5};

// Thirty magnetometers, 300 s at 62.5 Hz: seconds of all 30 calibrations.
double published_array_seconds(Method method);

// Table V: final errors, m, with the calibrations of the averaged IMU and of a single one.
struct PublishedGrade {
  const char* recording;
  double averaged, single;
};
const std::vector<PublishedGrade>& published_imu_grades();

}  // namespace magimu

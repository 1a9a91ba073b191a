// SPDX-License-Identifier: BSD-3-Clause
#include "study/published.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

struct PublishedSweep {
  PublishedRmse rmse[4];
  double seconds_of_ten[4];
};

constexpr PublishedSweep kRatesMap{{{0.002453, 9.889e-05, 0.0005465, 0.01378},
                                    {0.002619, 0.0001048, 0.0005801, 0.01609},
                                    {0.002034, 8.504e-05, 0.0005311, 0.01362},
                                    {0.00225, 8.234e-05, 0.0005381, 0.01306}},
                                   {6.964, 13.81, 26.23, 49.57}};
constexpr PublishedSweep kRatesKok{{{0.01516, 0.0002281, 0.001222, 0.1383},
                                    {0.01332, 0.000197, 0.001885, 0.1836},
                                    {0.0102, 0.0001736, 0.001172, 0.1491},
                                    {0.02217, 0.0002412, 0.002081, 0.2194}},
                                   {236.3, 467.1, 901.0, 1673.6}};
constexpr PublishedSweep kRatesWu{{{0.002722, 0.0001045, 0.04742, 0.141},
                                   {0.004144, 0.0001118, 0.09535, 0.2925},
                                   {0.002834, 0.0001663, 0.05404, 0.1504},
                                   {0.002821, 0.0001085, 0.07497, 0.1853}},
                                  {0.9352, 2.234, 4.960, 8.126}};
constexpr PublishedSweep kRatiosMap{{{0.00225, 8.234e-05, 0.0005381, 0.01306},
                                     {0.002252, 8.174e-05, 0.0005378, 0.01307},
                                     {0.002249, 8.364e-05, 0.0005381, 0.01305},
                                     {0.00225, 8.195e-05, 0.0005408, 0.01313}},
                                    {49.57, 25.02, 15.09, 10.64}};
constexpr PublishedSweep kRatiosKok{{{0.02217, 0.0002412, 0.002081, 0.2194},
                                     {0.02175, 0.0002589, 0.003451, 0.2329},
                                     {0.01543, 0.0002483, 0.003101, 0.2421},
                                     {0.01588, 0.000272, 0.002804, 0.252}},
                                    {1673.6, 1169.7, 925.8, 754.8}};
constexpr PublishedSweep kRatiosWu{{{0.002821, 0.0001085, 0.07497, 0.1853},
                                    {0.003301, 0.0001084, 0.08748, 0.2628},
                                    {0.003331, 0.0001079, 0.08904, 0.2793},
                                    {0.002992, 0.0001128, 0.1139, 0.2826}},
                                   {8.126, 5.059, 4.459, 3.592}};

// What was published under a method's name is what its published code gives.
const PublishedSweep* sweep_of(Method method, const PublishedSweep& map, const PublishedSweep& kok,
                               const PublishedSweep& wu) {
  switch (method) {
    case Method::kMap:
    case Method::kMapPublishedWeight:
      return &map;
    case Method::kKokPublished:
      return &kok;
    case Method::kWuPublished:
      return &wu;
    default:
      return nullptr;
  }
}

template <class T, std::size_t N>
std::optional<std::size_t> place_of(const std::array<T, N>& values, T value) {
  const auto found = std::ranges::find(values, value);
  if (found == values.end()) return std::nullopt;
  return static_cast<std::size_t>(found - values.begin());
}

const PublishedSweep* rates_of(Method m) { return sweep_of(m, kRatesMap, kRatesKok, kRatesWu); }
const PublishedSweep* ratios_of(Method m) { return sweep_of(m, kRatiosMap, kRatiosKok, kRatiosWu); }

}  // namespace

std::optional<PublishedRmse> published_rate_rmse(Method method, double rate_hz) {
  const auto place = place_of(kPublishedRates, rate_hz);
  const PublishedSweep* sweep = rates_of(method);
  if (!place || !sweep) return std::nullopt;
  return sweep->rmse[*place];
}

std::optional<PublishedRmse> published_ratio_rmse(Method method, int ratio) {
  const auto place = place_of(kPublishedRatios, ratio);
  const PublishedSweep* sweep = ratios_of(method);
  if (!place || !sweep) return std::nullopt;
  return sweep->rmse[*place];
}

double published_rate_seconds(Method method, double rate_hz) {
  const auto place = place_of(kPublishedRates, rate_hz);
  const PublishedSweep* sweep = rates_of(method);
  return place && sweep ? sweep->seconds_of_ten[*place] / 10.0 : kNoValue;
}

double published_ratio_seconds(Method method, int ratio) {
  const auto place = place_of(kPublishedRatios, ratio);
  const PublishedSweep* sweep = ratios_of(method);
  return place && sweep ? sweep->seconds_of_ten[*place] / 10.0 : kNoValue;
}

std::optional<PublishedRmse> published_delay_rmse(double delay_s) {
  static constexpr PublishedRmse kRmse[] = {{0.0031, 8.9e-5, 0.0005, 0.0330},
                                            {0.0022, 8.2e-5, 0.0005, 0.0130},
                                            {0.0040, 9.1e-5, 0.0005, 0.0269}};
  const auto place = place_of(kPublishedDelays, delay_s);
  if (!place) return std::nullopt;
  return kRmse[*place];
}

double published_array_seconds(Method method) {
  switch (method) {
    case Method::kMap:
      return 152.8;
    case Method::kKokPublished:
      return 5874.0;
    case Method::kWuPublished:
      return 23.02;
    default:
      return kNoValue;
  }
}

const std::vector<PublishedGrade>& published_imu_grades() {
  static const std::vector<PublishedGrade> grades{
      {"LP-1", 5.14, 5.17}, {"LP-2", 4.69, 4.72}, {"LP-3", 4.73, 4.72}, {"NP-1", 8.14, 7.95},
      {"NP-2", 5.90, 6.78}, {"NP-3", 6.50, 6.81}, {"NT-1", 5.33, 5.72}, {"NT-2", 3.19, 3.37}};
  return grades;
}

}  // namespace magimu

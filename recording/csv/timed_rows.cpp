// SPDX-License-Identifier: BSD-3-Clause
#include "recording/csv/timed_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace magimu {
namespace {

// The rows of a series by their times, those without a time left out, and all but the first of one
// time.
template <class Series>
void give_times_of(Series& series, const std::vector<double>& times) {
  const auto time = [&](std::size_t i) { return times[static_cast<std::size_t>(series.t[i])]; };
  bool increases = true;
  for (std::size_t i = 0; i < series.t.size() && increases; ++i) {
    increases = i == 0 ? !std::isnan(time(i)) : time(i) > time(i - 1);
  }
  if (increases) {
    for (double& t : series.t) t = times[static_cast<std::size_t>(t)];
    return;
  }
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < series.t.size(); ++i) {
    if (!std::isnan(time(i))) order.push_back(i);
  }
  std::ranges::stable_sort(order, {}, time);
  Series sorted;
  for (const std::size_t i : order) {
    if (!sorted.t.empty() && !(time(i) > sorted.t.back())) continue;
    sorted.t.push_back(time(i));
    sorted.v.push_back(series.v[i]);
  }
  series = std::move(sorted);
}

}  // namespace

void give_times(Recording& recording, const std::vector<double>& times) {
  for (VectorSeries* series : {&recording.acc, &recording.gyr}) give_times_of(*series, times);
  for (VectorSeries& series : recording.mag) give_times_of(series, times);
  for (auto& [name, series] : recording.aux) give_times_of(series, times);
  if (recording.pos) give_times_of(*recording.pos, times);
}

void recognise_tesla(Recording& recording) {
  constexpr double kNanotesla = 1e-3, kTesla = 1e6;
  if (recording.file_units.contains("mag") || recording.mag.empty()) return;
  double largest = 0.0;
  for (const VectorSeries& mag : recording.mag) {
    for (const Vector3& v : mag.v) largest = std::max(largest, v.cwiseAbs().maxCoeff());
  }
  if (largest == 0.0 || largest > kNanotesla) return;
  for (VectorSeries& mag : recording.mag) {
    for (Vector3& v : mag.v) v *= kTesla;
  }
  recording.file_units["mag"] = kTesla;
  recording.notes.push_back(
      fmt::format("mag is read as tesla: its largest reading is {:.3g}", largest));
}

}  // namespace magimu

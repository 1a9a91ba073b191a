// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/motion/slower_recordings.h"

#include <algorithm>

namespace magimu {
namespace {

constexpr double kEnoughRate =
    150.0;                    // Hz: 7 ms, in which an axis that turns at 10 rad/s moves 4 deg
constexpr double kGap = 1.5;  // usual intervals

bool is_slow(const Recording& r) {
  return samples_in_one(r.acc) == 1 && samples_in_one(r.gyr) == 1 &&
         std::ranges::all_of(r.mag, [](const VectorSeries& s) { return samples_in_one(s) == 1; });
}

}  // namespace

std::size_t samples_in_one(const VectorSeries& series) {
  return std::max<std::size_t>(1, std::size_t(series.rate_hz() / kEnoughRate));
}

VectorSeries means_of_groups(const VectorSeries& series, std::size_t count, TimeOfMean time) {
  if (count < 2) return series;
  const double longest = kGap / std::max(series.rate_hz(), 1e-9);
  VectorSeries out;
  out.t.reserve(series.size() / count + 1);
  out.v.reserve(series.size() / count + 1);
  // A gyroscope's last sample of a group lasts until the next group begins.
  const std::size_t reach = time == TimeOfMean::kFirst ? count : count - 1;
  for (std::size_t k = 0; k < series.size();) {
    bool together = k + count <= series.size();
    for (std::size_t i = k; together && i < std::min(k + reach, series.size() - 1); ++i) {
      together = series.t[i + 1] - series.t[i] < longest;
    }
    if (!together) {
      out.push_back(series.t[k], series.v[k]);
      ++k;
      continue;
    }
    double later = 0.0;
    Vector3 sum = Vector3::Zero();
    for (std::size_t i = k; i < k + count; ++i) {
      later += series.t[i] - series.t[k];
      sum += series.v[i];
    }
    const bool middle = time == TimeOfMean::kMiddle;
    out.push_back(series.t[k] + (middle ? later / double(count) : 0.0), sum / double(count));
    k += count;
  }
  return out;
}

SlowerRecordings::SlowerRecordings(const std::vector<const Recording*>& all) : recordings_(all) {
  for (const Recording*& r : recordings_) {
    if (is_slow(*r)) continue;
    Recording& slower = copies_.emplace_back();
    slower.name = r->name;
    slower.acc = means_of_groups(r->acc, samples_in_one(r->acc), TimeOfMean::kMiddle);
    slower.gyr = means_of_groups(r->gyr, samples_in_one(r->gyr), TimeOfMean::kFirst);
    for (const VectorSeries& mag : r->mag) {
      slower.mag.push_back(means_of_groups(mag, samples_in_one(mag), TimeOfMean::kMiddle));
    }
    slower.mag_names = r->mag_names;
    slower.aux = r->aux;
    slower.pos = r->pos;
    slower.set_aside = r->set_aside;
    slower.file_units = r->file_units;
    slower.continues_previous = r->continues_previous;
    r = &slower;
  }
}

}  // namespace magimu

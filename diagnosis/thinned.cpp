// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/thinned.h"

namespace magimu {
namespace {

constexpr double kFast = 150.0, kEnough = 75.0;  // Hz

VectorSeries means(const VectorSeries& series, bool time_of_first) {
  const double rate = series.rate_hz();
  if (!(rate > kFast)) return series;
  const auto n = std::size_t(rate / kEnough);
  VectorSeries out;
  for (std::size_t k = 0; k + n <= series.size(); k += n) {
    double t = 0.0;
    Vector3 v = Vector3::Zero();
    for (std::size_t i = k; i < k + n; ++i) {
      t += series.t[i] / double(n);
      v += series.v[i] / double(n);
    }
    out.push_back(time_of_first ? series.t[k] : t, v);
  }
  return out;
}

}  // namespace

Recording thinned(const Recording& recording) {
  Recording out = recording;
  out.acc = means(recording.acc, false);
  out.gyr = means(recording.gyr, true);
  for (VectorSeries& mag : out.mag) mag = means(mag, false);
  return out;
}

}  // namespace magimu

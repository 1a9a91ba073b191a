// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/sample_residuals.h"

#include <algorithm>
#include <cmath>

#include "calibration/model/extension.h"
#include "calibration/model/sensed_motion.h"
#include "calibration/motion/rests/rests.h"
#include "diagnosis/noise/high_pass.h"

namespace magimu {
namespace {

// Fills in lag1_at_rest and readings_at_rest: correlation of neighbouring readings about the mean
// of each rest, over the axes that are noisier than a step of the converter.
void look_at_rests(const VectorSeries& series, const std::vector<TimeSpan>& rests,
                   SampleResiduals& out) {
  constexpr std::size_t kLeast = 20;  // readings in a rest
  Vector3 squares = Vector3::Zero(), products = Vector3::Zero(), step = Vector3::Zero();
  double count = 0.0, begun = 0.0;
  for (const TimeSpan& rest : rests) {
    const auto first =
                   std::size_t(std::ranges::lower_bound(series.t, rest.begin_s) - series.t.begin()),
               last =
                   std::size_t(std::ranges::upper_bound(series.t, rest.end_s) - series.t.begin());
    if (last < first + kLeast) continue;
    Vector3 mean = Vector3::Zero();
    for (std::size_t k = first; k < last; ++k) mean += series.v[k] / double(last - first);
    for (std::size_t k = first; k < last; ++k) {
      const Vector3 x = series.v[k] - mean;
      squares += x.cwiseAbs2();
      if (k == first) continue;
      products += x.cwiseProduct(series.v[k - 1] - mean);
      const Vector3 change = (series.v[k] - series.v[k - 1]).cwiseAbs();
      for (int axis = 0; axis < 3; ++axis) {
        const bool smaller = step[axis] == 0.0 || change[axis] < step[axis];
        if (change[axis] > 0.0 && smaller) step[axis] = change[axis];
      }
    }
    count += double(last - first);
    begun += 1.0;
  }
  double lag1 = 0.0, axes = 0.0;
  for (int axis = 0; axis < 3 && count > 0.0; ++axis) {
    if (squares[axis] / count <= step[axis] * step[axis]) continue;
    lag1 += products[axis] / squares[axis];
    axes += 1.0;
  }
  if (axes == 0.0) return;
  // Of n readings about their own mean the correlation r of neighbours comes out as
  // r - (1 + 4 r) / n (Marriott and Pope 1954).
  out.lag1_at_rest = (lag1 / axes * count + begun) / (count - 4.0 * begun);
  out.readings_at_rest = axes * count;
}

}  // namespace

std::vector<SampleResiduals> sample_residuals(const Recording& recording, const Stage& stage,
                                              int index, const NoiseDensities& rest,
                                              bool noise_given) {
  const ModelSpec& spec = stage.spec();
  const Values& values = stage.result().values;
  const Recording corrected =
      extend(recording, stage.plans()[std::size_t(index)], spec, values).corrected;
  const SensedMotion motion(corrected, stage.plans()[std::size_t(index)], spec, values);
  const Vector3 acc_bias = values.at<Vector3>(key::acc_bias);
  const Vector3 mag_bias = values.at<Vector3>(key::mag_bias);
  const auto sigma = [&](double density, const VectorSeries& s) {
    return density * std::sqrt(s.rate_hz());
  };
  std::vector<SampleResiduals> out;
  const bool moving = is_moved(spec.motion);

  SampleResiduals acc{.channel = Sensor::kAcc,
                      .t = recording.acc.t,
                      .reading = recording.acc.v,
                      .sigma = sigma(rest.acc, recording.acc),
                      .sigma_given = noise_given,
                      .high_passed = moving};
  if (!moving) acc.of_white = fit_spectrum(stage, Sensor::kAcc, index, recording.gyr.rate_hz());
  if (moving) {
    acc.residual = high_passed(corrected.acc);
  } else {
    for (std::size_t k = 0; k < corrected.acc.size(); ++k) {
      const SampleState s = motion.state(Sensor::kAcc, k);
      acc.residual.push_back(corrected.acc.v[k] - s.f - acc_bias);
      acc.change.push_back(s.f.cross(s.omega));
      acc.across.push_back(s.f.normalized().cross(acc.change.back()));
    }
  }
  const std::vector<TimeSpan> rests = quiet_rests(recording, find_rests(recording));
  if (moving) look_at_rests(recording.acc, rests, acc);
  out.push_back(std::move(acc));
  out.push_back({.channel = Sensor::kGyr,
                 .t = recording.gyr.t,
                 .reading = recording.gyr.v,
                 .residual = high_passed(corrected.gyr),
                 .sigma = sigma(rest.gyr, recording.gyr),
                 .sigma_given = noise_given,
                 .high_passed = true});
  look_at_rests(recording.gyr, rests, out.back());
  SampleResiduals mag{
      .channel = Sensor::kMag,
      .t = recording.mag.front().t,
      .reading = recording.mag.front().v,
      .sigma = sigma(rest.mag, recording.mag.front()),
      .sigma_given = noise_given,
      .of_white = fit_spectrum(stage, Sensor::kMag, index, recording.gyr.rate_hz())};
  for (std::size_t k = 0; k < corrected.mag.front().size(); ++k) {
    const SampleState s = motion.state(Sensor::kMag, k);
    mag.residual.push_back(corrected.mag.front().v[k] - s.D * s.b - mag_bias);
    mag.change.push_back(s.D * s.b.cross(s.omega));
    mag.across.push_back(s.D * s.b.cross(s.b.cross(s.omega)));
    mag.to_n.push_back(s.nRb.matrix() * (s.strength_uT * s.D.inverse()));
  }
  out.push_back(std::move(mag));
  return out;
}

}  // namespace magimu

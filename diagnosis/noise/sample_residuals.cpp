// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/noise/sample_residuals.h"

#include <cmath>

#include "calibration/model/extension.h"
#include "calibration/model/sensed_motion.h"
#include "diagnosis/noise/high_pass.h"

namespace magimu {

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
  const bool moving = spec.motion == MotionModel::kHandHeld;

  SampleResiduals acc{.channel = Channel::kAcc,
                      .t = recording.acc.t,
                      .reading = recording.acc.v,
                      .sigma = sigma(rest.acc, recording.acc),
                      .sigma_given = noise_given,
                      .high_passed = moving};
  if (!moving) acc.of_white = fit_spectrum(stage, Sensor::kAcc, index);
  if (moving) {
    acc.residual = high_passed(corrected.acc);
  } else {
    for (std::size_t k = 0; k < corrected.acc.size(); ++k) {
      const SampleState s = motion.state(Channel::kAcc, k);
      acc.residual.push_back(corrected.acc.v[k] - s.f - acc_bias);
      acc.change.push_back(s.f.cross(s.omega));
      acc.across.push_back(s.f.normalized().cross(acc.change.back()));
    }
  }
  out.push_back(std::move(acc));
  out.push_back({.channel = Channel::kGyr,
                 .t = recording.gyr.t,
                 .reading = recording.gyr.v,
                 .residual = high_passed(corrected.gyr),
                 .sigma = sigma(rest.gyr, recording.gyr),
                 .sigma_given = noise_given,
                 .high_passed = true});
  SampleResiduals mag{.channel = Channel::kMag,
                      .t = recording.mag.front().t,
                      .reading = recording.mag.front().v,
                      .sigma = sigma(rest.mag, recording.mag.front()),
                      .sigma_given = noise_given,
                      .of_white = fit_spectrum(stage, Sensor::kMag, index)};
  for (std::size_t k = 0; k < corrected.mag.front().size(); ++k) {
    const SampleState s = motion.state(Channel::kMag, k);
    mag.residual.push_back(corrected.mag.front().v[k] - s.D * s.b - mag_bias);
    mag.change.push_back(s.D * s.b.cross(s.omega));
    mag.across.push_back(s.D * s.b.cross(s.b.cross(s.omega)));
    mag.to_n.push_back(s.nRb.matrix() * (s.strength_uT * s.D.inverse()));
  }
  out.push_back(std::move(mag));
  return out;
}

}  // namespace magimu

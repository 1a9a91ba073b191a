// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/trust/better_than_none.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "calibration/fit/parameter_prior.h"
#include "calibration/model/held_globals.h"
#include "factors/keys.h"

namespace magimu {

Stage with_readings_as_they_come(const std::vector<const Recording*>& recordings,
                                 const Stage& stage) {
  // uT: standard deviation with which the bias and D are held. Far below any residual.
  constexpr double kHeldWithin = 1e-2;
  Values start = stage.result().values, held;
  for (int m = 0; m < int(recordings.front()->mag.size()); ++m) {
    double sum = 0.0, n = 0.0;
    for (const Recording* r : recordings) {
      for (const Vector3& v : r->mag[std::size_t(m)].v) sum += v.norm();
      n += double(r->mag[std::size_t(m)].size());
    }
    const Matrix3 mounting = nearest_mounting(start.at<Matrix3>(key::distortion_of(m)));
    held.insert(key::distortion_of(m), Matrix3(sum / n * mounting));
    held.insert(key::mag_bias_of(m), Vector3(Vector3::Zero()));
    start.update(key::distortion_of(m), held.at<Matrix3>(key::distortion_of(m)));
    start.update(key::mag_bias_of(m), held.at<Vector3>(key::mag_bias_of(m)));
  }
  ModelSpec spec = stage.spec();
  spec.also = [also = spec.also, held](FactorGraph& graph) {
    if (also) also(graph);
    hold_globals(held, VectorXd::Constant(held.dim(), kHeldWithin / kHeldShare), graph);
  };
  Stage out(stage, spec);
  out.fit(start, true);
  return out;
}

double correction_rad(const Matrix3& D, const Vector3& bias) {
  const double strength = std::cbrt(std::abs(D.determinant()));
  const Matrix3 mounting = nearest_mounting(D);
  // D over its common scale, less its mounting, in the worst direction; and the bias as a share of
  // the field.
  const Matrix3 off = D / (D.cwiseProduct(mounting).sum() / 3.0) - mounting;
  return std::hypot(Eigen::JacobiSVD<Matrix3>(off).singularValues()[0], bias.norm() / strength);
}

Check no_gain_to_ask_for(double correction) {
  return {"gain", CheckStatus::kOk, 0.0,
          fmt::format("As they come the readings would be off by up to {:.0f} deg.",
                      std::min(correction, M_PI) / kDegree)};
}

Check check_gain(const BlockErrors& as_they_come, const BlockErrors& calibrated,
                 double strength_uT) {
  const auto degrees = [&](const BlockErrors& errors) {
    const double squares =
        std::accumulate(errors.held_out.begin(), errors.held_out.end(), 0.0) / errors.values;
    return std::sqrt(squares) / strength_uT / kDegree;
  };
  const HeldOutGain gain = held_out_gain(as_they_come, calibrated);
  const std::string numbers = fmt::format(
      "Readings that the fit has not seen are predicted to {:.2g} deg with this calibration, and "
      "to {:.2g} deg as they come, each with attitudes and dip of its own",
      degrees(calibrated), degrees(as_they_come));
  if (gain.worse() && degrees(calibrated) > degrees(as_they_come)) {
    return {"gain", CheckStatus::kBad, gain.ratio(),
            "Keep what you have: " + numbers +
                ". The calibration would make orientation worse where it changes with the "
                "attitude."};
  }
  if (!gain.better()) {
    return {"gain", CheckStatus::kOk, gain.ratio(),
            numbers +
                ": no gain is shown, and no loss. Readings of this sensor may be used as "
                "they come."};
  }
  return {"gain", CheckStatus::kOk, gain.ratio(),
          fmt::format("{}: {:.2g} times better.", numbers, gain.ratio())};
}

}  // namespace magimu

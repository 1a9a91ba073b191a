// SPDX-License-Identifier: BSD-3-Clause
#include "bench/real/blind_starts.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <mutex>

#include "study/error_statistics.h"

namespace magimu {
namespace {

constexpr double kSameParameters = 0.01;  // sigma
constexpr double kSameCost = 1e-6;

StartPerturbation blind(int seed) {
  return {.seed = std::uint64_t(seed),
          .tilt_rad = 30.0 * kDegree,
          .heading_rad = 60.0 * kDegree,
          .distortion = 0.2,
          .mag_bias_uT = 5.0};
}

bool has_effect(const Calibration& c, const std::string& name) {
  return std::any_of(c.effects.begin(), c.effects.end(),
                     [&](const ActiveEffect& effect) { return effect.name == name; });
}

// The largest difference of a parameter, in standard deviations of a.
double sigmas_apart(const Calibration& a, const Calibration& b, const MatrixXd& covariance) {
  const VectorXd difference = in_calibration_order(a) - in_calibration_order(b);
  double worst = 0.0;
  for (Eigen::Index i = 0; i < difference.size(); ++i) {
    if (covariance(i, i) <= 0.0) continue;  // undetermined
    worst = std::max(worst, std::abs(difference[i]) / std::sqrt(covariance(i, i)));
  }
  return worst;
}

}  // namespace

BlindStarts blind_starts(const Recording& recording, const Calibration& ordinary, int starts,
                         bool whole) {
  CalibrationOptions one_model;
  one_model.noise = ordinary.noise;
  one_model.motion = ordinary.motion;
  one_model.mag_time_offset = has_effect(ordinary, "mag_time_offset");
  one_model.gyr_matrix = has_effect(ordinary, "gyro_scale_misalignment");
  const Calibration minimum = calibrate(recording, one_model);

  BlindStarts out;
  out.starts = starts;
  std::mutex mutex;
  tbb::parallel_for(0, starts, [&](int i) {
    CalibrationOptions options = one_model;
    options.initialization.perturbation = blind(i + 1);
    const Calibration c = calibrate(recording, options);
    const double apart = sigmas_apart(minimum, c, minimum.covariance_model);
    const double cost = std::abs(c.fit.cost_final / minimum.fit.cost_final - 1.0);
    {
      const std::lock_guard lock(mutex);
      const bool sign = std::cos(c.parameters.dip_rad) > 0.0;
      if (!sign) ++out.wrong_sign;
      if (c.fit.converged() && sign && (apart <= kSameParameters || cost <= kSameCost)) {
        ++out.same;
        out.worst = std::max(out.worst, apart);
      } else if (c.trust.verdict != Verdict::kNo) {
        ++out.trusted;
      }
    }
    if (!whole) return;
    CalibrationOptions everything;
    everything.initialization.perturbation = blind(i + 1);
    const Calibration w = calibrate(recording, everything);
    const double far = sigmas_apart(ordinary, w, ordinary.covariance);
    const std::lock_guard lock(mutex);
    out.whole_worst = std::max(out.whole_worst, far);
    if (w.motion == ordinary.motion && w.effects.size() == ordinary.effects.size() &&
        w.trust.verdict == ordinary.trust.verdict && far <= BlindStarts::kWholeSame) {
      ++out.whole_same;
    }
  });
  return out;
}

}  // namespace magimu

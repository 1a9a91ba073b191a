// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/trust/no_fit.h"

#include <fmt/format.h>

#include <cmath>

#include "calibration/model/parameter_names.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kUsualField = 50.0;                       // uT
constexpr NoiseDensities kOrdinaryParts{0.01, 1e-3, 0.1};  // per sqrt(Hz)

// Length of a magnetometer's reading in the middle of all.
double usual_length(const std::vector<const Recording*>& recordings, std::size_t sensor) {
  std::vector<double> lengths;
  for (const Recording* r : recordings) {
    for (const Vector3& m : r->mag[sensor].v) {
      const double length = m.norm();
      if (length > 0.0 && std::isfinite(length)) lengths.push_back(length);
    }
  }
  return lengths.empty() ? kUsualField : median(lengths);
}

}  // namespace

Calibration calibration_without_fit(const std::vector<const Recording*>& recordings,
                                    const CalibrationOptions& options, const std::string& why,
                                    const std::vector<std::string>& warnings) {
  Calibration c;
  c.mag_names = recordings.front()->mag_names;
  const auto mags = recordings.front()->mag.size();
  c.parameters.mag.clear();
  std::vector<double> sigma = {options.gravity, options.gravity, options.gravity, 1.0, 1.0, 1.0};
  for (std::size_t m = 0; m < mags; ++m) {
    const double length = usual_length(recordings, m);
    c.parameters.mag.push_back({length * Matrix3::Identity(), Vector3::Zero()});
    sigma.insert(sigma.end(), 12, length);
    if (m == 0) c.strength_uT = c.strength_sigma_uT = c.strength_sigma_model_uT = length;
  }
  for (const Recording* r : recordings) {
    c.samples += int(r->gyr.size());
    if (r->continues_previous && !c.fields.empty()) continue;  // a part of the same recording
    c.fields.push_back({r->name, 0.0, 90.0 * kDegree, 90.0 * kDegree});
    sigma.push_back(90.0);
    for (const SetAside& s : r->set_aside) c.set_aside.push_back({r->name, s});
  }
  c.order = parameter_names(int(mags), int(c.fields.size()), ModelSpec{});
  const VectorXd squares =
      Eigen::Map<const VectorXd>(sigma.data(), Eigen::Index(sigma.size())).cwiseAbs2();
  c.covariance = c.covariance_model = squares.asDiagonal();
  c.noise = options.noise.value_or(kOrdinaryParts);
  c.noise_given = options.noise.has_value();
  c.gravity = options.gravity;
  c.fit.reason = StopReason::kNotFinite;
  c.fit.message = why;
  c.trust.lower(Verdict::kNo, fmt::format("No fit could be made: {}.", why));
  c.warnings = warnings;
  for (const std::string& warning : warnings) c.trust.reasons.push_back(warning);
  return c;
}

Calibration calibration_without_fit(const std::vector<const Recording*>& recordings,
                                    const CalibrationOptions& options,
                                    const TooLittle& too_little) {
  const std::string name = too_little.file.empty() ? "" : too_little.file + ": ";
  return calibration_without_fit(recordings, options,
                                 name + too_little.problem + "; " + too_little.remedy, {});
}

}  // namespace magimu

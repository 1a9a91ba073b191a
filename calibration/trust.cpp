// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/trust.h"

#include <fmt/format.h>

#include "calibration/rests.h"

namespace magimu {
namespace {

// The accelerometer must read gravity and its bias: so much else (RMS) is a hand that moves it.
constexpr double kAccResidualNo = 1.0;        // m/s^2
constexpr double kAccResidualLimited = 0.35;  // m/s^2
constexpr double kPlausibleAccBias = 0.7;     // m/s^2; 70 mg, beyond any part that works
constexpr double kMaxDipSigma_deg = 2.0;
constexpr double kMaxDistortionSigma = 0.05;  // of the strength

void judge_fit(Calibration& c) {
  if (!c.fit.converged()) {
    c.trust.lower(Verdict::kNo, "The optimization did not reach the optimum: " + c.fit.message);
  }
  for (const std::string& direction : c.undetermined) {
    c.trust.lower(Verdict::kNo,
                  "The motion leaves a combination of parameters undetermined: " + direction +
                      ". Turn the sensor about all three of its axes, by half a turn and more.");
  }
}

void judge_motion(Calibration& c) {
  if (c.motion == MotionModel::kHandHeld) return;  // the model carries it
  const double acc = c.residuals[0].rms_unit, bias = c.parameters.acc_bias.norm();
  if (acc > kAccResidualNo || bias > kPlausibleAccBias) {
    c.trust.lower(
        Verdict::kNo,
        fmt::format("The hand moved the sensor: beyond gravity and a bias the accelerometer reads "
                    "{:.2f} m/s^2 RMS (its bias comes out as {:.2f} m/s^2), and this model assumes "
                    "that the sensor only turns. Turn it on the spot, slowly.",
                    acc, bias));
  } else if (acc > kAccResidualLimited) {
    c.trust.lower(Verdict::kLimited,
                  fmt::format("The hand moved the sensor somewhat: beyond gravity and a bias the "
                              "accelerometer reads {:.2f} m/s^2 RMS; the accelerometer bias suffers "
                              "most. Turn it on the spot, slowly.",
                              acc));
  }
}

void judge_uncertainty(Calibration& c) {
  for (const FieldEstimate& f : c.fields) {
    if (f.dip_sigma_rad > kMaxDipSigma_deg * kDegree) {
      c.trust.lower(Verdict::kLimited,
                    fmt::format("The dip is known to {:.1f} deg only.", f.dip_sigma_rad / kDegree));
    }
  }
  for (std::size_t i = 0; i < c.order.size(); ++i) {
    if (c.order[i].find(".distortion") == std::string::npos) continue;
    const double sigma = std::sqrt(c.covariance(Eigen::Index(i), Eigen::Index(i)));
    if (sigma > kMaxDistortionSigma * c.strength_uT) {
      c.trust.lower(Verdict::kLimited,
                    fmt::format("{} is known to {:.1f} uT only, {:.0f} % of the field: some "
                                "directions were hardly visited.",
                                c.order[i], sigma, 100.0 * sigma / c.strength_uT));
      break;
    }
  }
}

}  // namespace

void judge(Calibration& c, const std::vector<const Recording*>& recordings) {
  judge_fit(c);
  judge_motion(c);
  judge_uncertainty(c);
  (void)recordings;
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/diagnostics.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "factors/sensor_model.h"
#include "graph/decompositions.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kStepDone = 0.01;                        // sigmas
constexpr double kAccuracyOk = 1.0, kAccuracyPoor = 3.0;  // deg
constexpr double kNotKnown = 90.0;   // deg: any direction; the number would say nothing
constexpr double kWhiteBelow = 0.2;  // correlation
constexpr double kWindow = 5.0;      // s
constexpr double kWindowOut = 3.0;   // times the usual
constexpr double kHeldOutOk = 0.03, kHeldOutPoor = 0.1;  // of the strength
constexpr double kHalvesOk = 2.0, kHalvesPoor = 4.0;     // sigmas

CheckStatus graded(double value, double ok, double poor) {
  return value <= ok ? CheckStatus::kOk : value <= poor ? CheckStatus::kCaution : CheckStatus::kBad;
}

// 14 directions: axes and diagonals.
std::vector<Vector3> directions() {
  std::vector<Vector3> out;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const int axes = std::abs(x) + std::abs(y) + std::abs(z);
        if (axes == 1 || axes == 3) out.push_back(Vector3(x, y, z).normalized());
      }
    }
  }
  return out;
}

}  // namespace

Check check_optimum(const Result& fit) {
  const double step = fit.trace.empty() ? 0.0 : fit.trace.back().step_sigma;
  Check check{"optimum", CheckStatus::kOk, step, fit.message};
  if (!fit.converged()) {
    check.status = CheckStatus::kBad;
  } else if (step > kStepDone) {
    check.status = CheckStatus::kCaution;
    check.sentence += fmt::format(" The last step was {:.2g} standard deviations long.", step);
  }
  return check;
}

bool field_came_near(const Calibration& c, const Vector3& direction) {
  constexpr double kNear = 20.0 * kDegree;  // as coverage_of() counts
  for (std::size_t r = 0; r < c.trajectories.size() && !c.fields.empty(); ++r) {
    const Vector3 b = unit_field(c.fields[std::min(r, c.fields.size() - 1)].dip_rad);
    if (std::ranges::any_of(c.trajectories[r].nRb, [&](const Rot3& nRb) {
          return nRb.unrotate(b).dot(direction) > std::cos(kNear);
        })) {
      return true;
    }
  }
  return false;
}

Check check_accuracy(const Calibration& c, std::size_t magnetometer) {
  double worst = 0.0;
  Vector3 where = Vector3::UnitX();
  const Matrix3 D_inverse = c.parameters.mag[magnetometer].distortion.inverse();
  const Eigen::Index own = 6 + 12 * Eigen::Index(magnetometer);
  const MatrixXd P = c.covariance.block(own, own, 12, 12);  // of D, column by column, and o_m
  for (const Vector3& b : directions()) {
    // d (D^-1 (mag - o_m)) = -D^-1 (dD b + do_m), across b.
    Mat<double, 3, 12> J;
    for (int j = 0; j < 3; ++j) J.middleCols<3>(3 * j) = b[j] * D_inverse;
    J.rightCols<3>() = D_inverse;
    const Matrix3 across = Matrix3::Identity() - b * b.transpose();
    const MatrixXd V = across * (J * P * J.transpose()) * across;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(V, Eigen::EigenvaluesOnly);
    if (eigen.eigenvalues().maxCoeff() > worst) {
      worst = eigen.eigenvalues().maxCoeff();
      where = b;
    }
  }
  const double deg = std::sqrt(worst) / kDegree;
  if (deg <= kAccuracyOk) {
    return {"accuracy", CheckStatus::kOk, deg,
            fmt::format("The corrected field's direction is known to {:.2g} deg or better (one "
                        "standard deviation), however the sensor is held.",
                        deg)};
  }
  const char* const why = field_came_near(c, where)
                              ? ". The sensor was held so, too: what limits it is not the motion "
                                "but noise, or what the model lacks."
                              : ": turn the sensor through those that were hardly visited.";
  if (!(deg < kNotKnown)) {
    return {"accuracy", CheckStatus::kBad, deg,
            fmt::format("The corrected field's direction is not known in some attitudes{}", why)};
  }
  return {"accuracy", graded(deg, kAccuracyOk, kAccuracyPoor), deg,
          fmt::format("The corrected field's direction is known to {:.2g} deg only (one standard "
                      "deviation) in some attitudes{}",
                      deg, why)};
}

Check check_whiteness(const Calibration& c) {
  const double lag1 = c.residuals[2].lag1;
  if (std::abs(lag1) < kWhiteBelow) {
    return {"whiteness", CheckStatus::kOk, lag1,
            fmt::format("The magnetometer's residuals look like noise (correlation of neighbours "
                        "{:.2f}).",
                        lag1)};
  }
  return {"whiteness", CheckStatus::kCaution, lag1,
          fmt::format("The magnetometer's residuals are not white (correlation of neighbours "
                      "{:.2f}): something is not in the model. The sigmas take it into account, "
                      "those of the model alone do not.",
                      lag1)};
}

Check check_windows(const Calibration& c, const std::vector<double>& mag_squares) {
  std::vector<double> nis;
  std::size_t node = 0;
  for (const TrajectoryEstimate& trajectory : c.trajectories) {
    double sum = 0.0, end = trajectory.t.front() + kWindow;
    int count = 0;
    for (const double t : trajectory.t) {
      if (t >= end && count > 0) {
        nis.push_back(sum / count);
        sum = 0.0;
        count = 0;
        end = t + kWindow;
      }
      sum += mag_squares[node++];
      ++count;
    }
  }
  if (nis.empty()) nis.push_back(0.0);
  const double usual = std::max(quantile(nis, 0.5), 1e-12);
  const auto out =
      std::count_if(nis.begin(), nis.end(), [&](double x) { return x > kWindowOut * usual; });
  const double share = double(out) / double(nis.size());
  return {"windows", graded(share, 0.0, 0.2), share,
          out == 0
              ? fmt::format("All {} windows of {:.0f} s fit alike (largest mean square {:.1f} "
                            "times the usual).",
                            nis.size(), kWindow, *std::max_element(nis.begin(), nis.end()) / usual)
              : fmt::format("{} of {} windows of {:.0f} s fit worse than the others (mean "
                            "square up to {:.0f} times the usual): the field or the sensor "
                            "was not the same there.",
                            out, nis.size(), kWindow,
                            *std::max_element(nis.begin(), nis.end()) / usual)};
}

Check check_held_out(const BlockErrors& errors, double strength_uT) {
  const auto rms = [&](const std::vector<double>& squares) {
    return std::sqrt(std::accumulate(squares.begin(), squares.end(), 0.0) / errors.values);
  };
  const double held_out = rms(errors.held_out), share = held_out / strength_uT;
  return {
      "cross_validation", graded(share, kHeldOutOk, kHeldOutPoor), share,
      fmt::format("Magnetometer samples left out of the fit, up to 5 s at a time, are predicted to "
                  "{:.2g} uT ({:.2g} % of the field; in the fit: {:.2g} uT).",
                  held_out, 100.0 * share, rms(errors.fitted))};
}

namespace {

// Of the magnetometers' parameters, each in standard deviations of the difference: 12 each.
VectorXd apart(const Calibration& one, const Calibration& other) {
  const auto mags = Eigen::Index(one.parameters.mag.size());
  VectorXd difference(12 * mags);
  for (Eigen::Index m = 0; m < mags; ++m) {
    const MagnetometerParameters &a = one.parameters.mag[std::size_t(m)],
                                 &b = other.parameters.mag[std::size_t(m)];
    difference.segment<9>(12 * m) = (a.distortion - b.distortion).reshaped();
    difference.segment<3>(12 * m + 9) = a.bias - b.bias;
  }
  const MatrixXd P = one.covariance.block(6, 6, 12 * mags, 12 * mags) +
                     other.covariance.block(6, 6, 12 * mags, 12 * mags);
  return difference.cwiseQuotient(P.diagonal().cwiseMax(1e-300).cwiseSqrt());
}

double rms_of(const VectorXd& z) { return std::sqrt(z.squaredNorm() / double(z.size())); }

}  // namespace

Check check_halves(const Calibration& first, const Calibration& second) {
  const VectorXd z = apart(first, second);
  const double rms = rms_of(z);
  const CheckStatus status = grade_halves(rms);
  Check out{"halves", status, rms,
            fmt::format("Calibrated by themselves, the first and the second half {} ({:.1f} of "
                        "their standard deviations apart, root mean square).",
                        status == CheckStatus::kOk ? "agree" : "disagree", rms)};
  const auto mags = Eigen::Index(first.parameters.mag.size());
  for (Eigen::Index m = 0; mags > 1 && m < mags; ++m) {
    out.of_magnetometers.push_back(std::sqrt(z.segment<12>(12 * m).squaredNorm() / 12.0));
  }
  return out;
}

std::optional<Check> check_recordings(const std::vector<std::optional<Calibration>>& each,
                                      const std::vector<std::string>& names) {
  std::optional<Check> out;
  for (std::size_t a = 0; a < each.size(); ++a) {
    for (std::size_t b = a + 1; b < each.size(); ++b) {
      if (!each[a] || !each[b]) continue;
      const double rms = rms_of(apart(*each[a], *each[b]));
      if (out && rms <= out->value) continue;
      const CheckStatus status = grade_halves(rms);
      out = Check{"recordings", status, rms,
                  status == CheckStatus::kOk
                      ? fmt::format("Calibrated by themselves, the recordings agree ({:.1f} of "
                                    "their standard deviations apart at the most, root mean "
                                    "square).",
                                    rms)
                      : fmt::format("Calibrated by themselves, {} and {} disagree about the "
                                    "magnetometer ({:.1f} of their standard deviations apart, root "
                                    "mean square): the device or its place changed in between, or "
                                    "something was near it in one of them. Calibrate each by "
                                    "itself; `magimu diagnose` of the one `--against` the "
                                    "calibration of the other tells what changed.",
                                    names[a], names[b], rms)};
    }
  }
  return out;
}

CheckStatus grade_halves(double rms) { return graded(rms, kHalvesOk, kHalvesPoor); }

}  // namespace magimu

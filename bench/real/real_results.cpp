// SPDX-License-Identifier: BSD-3-Clause
#include "bench/real/real_results.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "bench/real/orientation_filter.h"
#include "calibration/motion/integrated_rotation.h"

namespace magimu {
namespace {

constexpr Eigen::Index kDistortion = 6, kMagBias = 15;  // rows of the covariance

using RotationPairs = std::vector<std::pair<Rot3, Rot3>>;  // estimate, truth

double rms_deg(const RotationPairs& pairs) {
  double sum = 0.0;
  for (const auto& [estimate, truth] : pairs) {
    sum += (estimate * truth.inverse()).Log().squaredNorm();
  }
  return std::sqrt(sum / double(std::max<std::size_t>(1, pairs.size()))) / kDegree;
}

// The estimate at the times of the truth plus a shift.
RotationPairs matched(const TrajectoryEstimate& estimate, const IntegratedRotation& gyr,
                      const MotionTruth& truth, double shift_s) {
  constexpr std::size_t kEvery = 5;  // samples of the truth
  RotationPairs out;
  std::size_t k = 0;
  for (std::size_t j = 0; j < truth.t.size(); j += kEvery) {
    const double t = truth.t[j] + shift_s;
    while (k + 1 < estimate.t.size() && estimate.t[k + 1] <= t) ++k;
    if (!truth.valid[j] || t < estimate.t.front() || t > estimate.t.back()) continue;
    out.emplace_back(estimate.nRb[k] * gyr.between(estimate.t[k], t), truth.nRb[j]);
  }
  return out;
}

// Turns all estimates by one rotation from the left and one from the right, nearest to the truth.
void align(RotationPairs& pairs) {
  for (int round = 0; round < 10; ++round) {
    Vector3 left = Vector3::Zero(), right = Vector3::Zero();
    for (const auto& [estimate, truth] : pairs) {
      left += (estimate * truth.inverse()).Log() / double(pairs.size());
    }
    for (auto& [estimate, truth] : pairs) estimate = Rot3::Exp(-left) * estimate;
    for (const auto& [estimate, truth] : pairs) {
      right += (truth.inverse() * estimate).Log() / double(pairs.size());
    }
    for (auto& [estimate, truth] : pairs) estimate = estimate * Rot3::Exp(-right);
  }
}

}  // namespace

std::string RealResult::number() const {
  return recording.name.substr(0, recording.name.find('_'));
}

std::string RealResult::name() const {
  std::string out;
  const std::string stem = recording.name.substr(0, recording.name.find('.'));
  for (std::size_t at = stem.find('_'); at < stem.size();) {
    const std::size_t end = std::min(stem.find('_', at + 1), stem.size());
    const std::string word = stem.substr(at + 1, end - at - 1);
    at = end;
    if (word.size() < 2 || word == "undisturbed" || word == "disturbed") continue;
    out += (out.empty() ? "" : " ") + word;
  }
  return out;
}

RealResult evaluate(Recording recording) {
  RealResult r;
  r.recording = std::move(recording);
  CalibrationOptions options;
  options.motion = MotionModel::kRotation;
  r.rotation = calibrate(r.recording, options);
  r.ours = calibrate(r.recording);
  r.uncalibrated_trajectory = track(r.recording, {});
  if (!r.recording.truth) return r;
  const MotionTruth& truth = *r.recording.truth;
  r.uncalibrated = orientation_error(r.uncalibrated_trajectory, truth);
  r.rotation_error = orientation_error(r.rotation.trajectories.front(), truth);
  r.ours_error = orientation_error(r.ours.trajectories.front(), truth);
  r.rotation_filter = filter_error(r.recording, r.rotation);
  r.ours_filter = filter_error(r.recording, r.ours);
  r.parts = error_parts(r.recording, r.ours);
  return r;
}

OrientationError filter_error(const Recording& recording, const Calibration& calibration) {
  return orientation_error(track(recording, corrections(calibration)), *recording.truth);
}

ErrorParts error_parts(const Recording& recording, const Calibration& calibration) {
  constexpr int kFurthest = 15;  // ms
  const Corrections c = corrections(calibration);
  const IntegratedRotation gyr(recording.gyr, c.parameters.gyr_bias, c.gyr_matrix);
  ErrorParts out;
  out.shifted_deg = INFINITY;
  RotationPairs best;
  for (int ms = -kFurthest; ms <= kFurthest; ++ms) {
    RotationPairs pairs =
        matched(calibration.trajectories.front(), gyr, *recording.truth, 1e-3 * ms);
    const double error = rms_deg(pairs);
    if (ms == 0) out.delivered_deg = error;
    if (error >= out.shifted_deg) continue;
    out.shift_ms = ms;
    out.shifted_deg = error;
    best = std::move(pairs);
  }
  align(best);
  out.aligned_deg = rms_deg(best);
  return out;
}

CrossApplication cross_apply(const RealResult& calibrated, const RealResult& applied) {
  return {calibrated.number(), applied.number(), applied.ours_filter.total_deg,
          filter_error(applied.recording, calibrated.ours).total_deg,
          applied.uncalibrated.total_deg};
}

NormalizedDistortion normalized_distortion(const Calibration& calibration) {
  using Vector9 = Vec<double, 9>;
  using Matrix9 = Eigen::Matrix<double, 9, 9>;
  const Matrix3& D = calibration.parameters.mag.front().distortion;
  const double s = std::cbrt(D.determinant());
  const Matrix3 slope = D.inverse().transpose() / 3.0;  // d log s / d D
  // d (D / s) = (dD - D d log s) / s
  const Matrix9 J =
      (Matrix9::Identity() - Vector9(D.reshaped()) * Vector9(slope.reshaped()).transpose()) / s;
  const auto P = calibration.covariance.block<9, 9>(kDistortion, kDistortion);
  return {Vector9(D.reshaped()) / s, J * P * J.transpose()};
}

Repeatability repeatability(const std::vector<const Calibration*>& calibrations) {
  struct Group {
    VectorXd value, variance;
  };
  std::vector<std::array<Group, 3>> groups;
  for (const Calibration* c : calibrations) {
    const VectorXd variance = c->covariance.diagonal();
    const NormalizedDistortion D = normalized_distortion(*c);
    groups.push_back({Group{c->parameters.acc_bias, variance.head<3>()},
                      Group{c->parameters.mag.front().bias, variance.segment<3>(kMagBias)},
                      Group{D.value, D.covariance.diagonal()}});
  }
  Repeatability out;
  std::array<double, 3> squares{};
  double total = 0.0, count = 0.0;
  for (std::size_t g = 0; g < 3; ++g) {
    double n = 0.0, difference2 = 0.0, variances = 0.0;
    for (std::size_t a = 0; a < groups.size(); ++a) {
      for (std::size_t b = a + 1; b < groups.size(); ++b) {
        const Group &p = groups[a][g], &q = groups[b][g];
        const Eigen::ArrayXd d2 = (p.value - q.value).array().square();
        const Eigen::ArrayXd v = (p.variance + q.variance).array();
        squares[g] += (d2 / v).sum();
        difference2 += d2.sum();
        variances += v.sum();
        n += double(d2.size());
      }
    }
    if (n == 0.0) return out;
    total += squares[g];
    count += n;
    squares[g] = std::sqrt(squares[g] / n);
    out.difference[g] = {std::sqrt(difference2 / n), std::sqrt(variances / n)};
  }
  out.acc_bias = squares[0];
  out.mag_bias = squares[1];
  out.distortion = squares[2];
  out.all = std::sqrt(total / count);
  return out;
}

TimeSeries error_over_time(const TrajectoryEstimate& estimate, const MotionTruth& truth,
                           int points) {
  TimeSeries out;
  const double begin = estimate.t.front(), step = (estimate.t.back() - begin) / points;
  std::size_t k = 0, j = 0;
  for (int i = 0; i < points; ++i) {
    const double end = begin + step * (i + 1);
    TrajectoryEstimate part;
    MotionTruth seen;
    for (; k < estimate.t.size() && estimate.t[k] < end; ++k) {
      part.t.push_back(estimate.t[k]);
      part.nRb.push_back(estimate.nRb[k]);
    }
    // Truth a little beyond both ends, so that every node finds its neighbour.
    while (j < truth.t.size() && truth.t[j] < end - step - 0.02) ++j;
    for (std::size_t l = j; l < truth.t.size() && truth.t[l] < end + 0.02; ++l) {
      seen.t.push_back(truth.t[l]);
      seen.nRb.push_back(truth.nRb[l]);
      seen.valid.push_back(truth.valid[l]);
    }
    const OrientationError e = orientation_error(part, seen);
    out.t.push_back(end - 0.5 * step);
    out.value.push_back(e.compared > 0 ? e.total_deg : NAN);
  }
  return out;
}

std::array<TimeSeries, 3> mag_residual_over_time(const Recording& recording,
                                                 const Calibration& calibration, int points) {
  const Corrections c = corrections(calibration);
  const SensorParameters& p = c.parameters;
  const TrajectoryEstimate& trajectory = calibration.trajectories.front();
  const IntegratedRotation gyr(recording.gyr, p.gyr_bias, c.gyr_matrix);
  const double begin = trajectory.t.front(), step = (trajectory.t.back() - begin) / points;
  std::vector<Vector3> sum(std::size_t(points), Vector3::Zero());
  std::vector<int> count(std::size_t(points), 0);
  const VectorSeries& mag = recording.mag.front();
  std::size_t k = 0;
  for (std::size_t i = 0; i < mag.size(); ++i) {
    const double t = mag.t[i] - c.mag_lag_s;
    const auto bin = int(std::floor((t - begin) / step));
    if (bin < 0 || bin >= points) continue;
    while (k + 1 < trajectory.t.size() &&
           std::abs(trajectory.t[k + 1] - t) <= std::abs(trajectory.t[k] - t)) {
      ++k;
    }
    const Rot3 nRb = trajectory.nRb[k] * gyr.between(trajectory.t[k], t);
    sum[std::size_t(bin)] +=
        mag.v[i] - magnetometer_model(nRb, p.mag.front().distortion, p.mag.front().bias, p.dip_rad);
    ++count[std::size_t(bin)];
  }
  std::array<TimeSeries, 3> out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t b = 0; b < sum.size(); ++b) {
      out[axis].t.push_back(begin + step * (double(b) + 0.5));
      out[axis].value.push_back(count[b] > 0 ? sum[b][Eigen::Index(axis)] / count[b] : NAN);
    }
  }
  return out;
}

}  // namespace magimu

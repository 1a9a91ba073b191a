// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/rivals/rival_calibration.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <chrono>
#include <cmath>

#include "calibration/fit/diagnostics.h"
#include "calibration/fit/given_noise.h"
#include "calibration/fit/uncertainty.h"
#include "calibration/model/parameter_names.h"
#include "calibration/pipeline.h"
#include "calibration/rivals/kok_published.h"
#include "calibration/rivals/wu_filter.h"
#include "calibration/start/attitude.h"
#include "calibration/trust/check_axes.h"
#include "calibration/trust/mounting.h"
#include "calibration/trust/trust.h"
#include "graph/numerical_error.h"
#include "graph/thread_time.h"
#include "recording/data/error.h"
#include "recording/data/well_formed.h"

namespace magimu {
namespace {

constexpr double kPublishedStart = 1e-3;      // rad: where the first orientation is the identity
constexpr double kPublishedRealStart = 1e-2;  // rad: where it is found from the first samples

// What either method ends with, before it is a Calibration.
struct RivalResult {
  SensorParameters theta;
  std::vector<double> dip_rad;
  MatrixXd covariance;
  std::vector<std::vector<Rot3>> nRb;
  std::vector<std::vector<FilterStep>> steps;
  Result fit;
  double rms[2] = {0.0, 0.0}, lag[2] = {0.0, 0.0};  // of whitened innovations: acc, mag
  long filter_runs = 0;
};

std::vector<Rot3> starts(const std::vector<const Recording*>& recordings, const KokProblem& problem,
                         const InitialGuess& guess) {
  std::vector<Rot3> out;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const IntegratedRotation gyr(recordings[r]->gyr, guess.parameters.gyr_bias);
    out.push_back(
        estimate_attitudes(*recordings[r], guess.parameters, gyr, {problem.steps(r).front().t})
            .front());
  }
  return out;
}

RivalResult by_kok(const RivalOptions& rival, const std::vector<const Recording*>& recordings,
                   const CalibrationOptions& options, const InitialGuess& guess,
                   const NoiseDensities& noise) {
  KokProblemOptions asked;
  asked.noise = noise;
  asked.gravity = options.gravity;
  asked.estimate_start = !rival.as_published;
  if (rival.as_published) {
    asked.start_sigma_rad = rival.start_at_identity ? kPublishedStart : kPublishedRealStart;
  }
  const KokProblem problem(recordings, asked);
  KokPoint start{guess.parameters, guess.dip_rad, starts(recordings, problem, guess)};
  if (rival.as_published && rival.start_at_identity) start.start.assign(recordings.size(), Rot3());
  const KokEstimate e =
      rival.as_published
          ? kok_published(problem, start,
                          {.evaluations_per_parameter = rival.evaluations_per_parameter})
          : kok_scoring(problem, start, options.optimizer);
  RivalResult out{e.point.theta, e.point.dip_rad, e.covariance, {}, {}, e.fit};
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    out.nRb.push_back(problem.orientations(e.point, r));
    out.steps.push_back(problem.steps(r));
  }
  const double acc = double(e.sums.acc_rows), mag = double(e.sums.rows - e.sums.acc_rows);
  out.rms[0] = std::sqrt(e.sums.acc_squares / acc);
  out.rms[1] = std::sqrt((e.sums.squares - e.sums.acc_squares) / mag);
  out.lag[0] = e.sums.acc_lag / e.sums.acc_squares;
  out.lag[1] = e.sums.mag_lag / (e.sums.squares - e.sums.acc_squares);
  out.filter_runs = e.filter_runs;
  return out;
}

RivalResult by_wu(const RivalOptions& rival, const std::vector<const Recording*>& recordings,
                  const CalibrationOptions& options, const InitialGuess& guess,
                  const NoiseDensities& noise) {
  if (rival.as_published && recordings.size() > 1) {
    throw InputError(recordings[1]->name, 0, 0,
                     "the published filter of Wu goes through one recording without a long gap",
                     "give one recording, or take the method not as published (--as-published)");
  }
  const WuOptions asked{noise, options.gravity};
  const WuEstimate e = rival.as_published
                           ? wu_published(*recordings.front(), guess.parameters.gyr_bias, asked)
                           : wu_filter(recordings, guess.parameters, guess.dip_rad, asked);
  RivalResult out{e.theta, e.dip_rad, e.covariance, e.nRb, {}, {}};
  for (const Recording* r : recordings) out.steps.push_back(filter_steps(*r));
  out.rms[0] = out.rms[1] = std::sqrt(e.squares / double(e.rows));
  out.fit.iterations = e.passes;
  out.filter_runs = e.passes;
  out.fit.solver = "extended Kalman filter";
  const bool settled = rival.as_published || e.last_change < 1e-1;
  out.fit.reason = settled ? StopReason::kConverged : StopReason::kMaxIterations;
  out.fit.message =
      rival.as_published
          ? std::string("One pass through the samples.")
          : fmt::format(
                "The last of {} passes moved no parameter by more than {:.1g} standard "
                "deviations.",
                e.passes, e.last_change);
  return out;
}

// det D > 0 and cos(dip) > 0, as everywhere; and D's sign decides the dip's.
void fix_rival_symmetries(RivalResult& r) {
  if (r.theta.mag.front().distortion.determinant() < 0.0) {
    // (D, alpha, R) -> (-D, -alpha, Rz(180 deg) R)
    for (MagnetometerParameters& mag : r.theta.mag) mag.distortion *= -1.0;
    VectorXd sign = VectorXd::Ones(r.covariance.rows());
    for (std::size_t m = 0; m < r.theta.mag.size(); ++m) {
      sign.segment<9>(6 + 12 * Eigen::Index(m)).setConstant(-1.0);
    }
    sign.tail(Eigen::Index(r.dip_rad.size())).setConstant(-1.0);
    r.covariance = sign.asDiagonal() * r.covariance * sign.asDiagonal();
    for (double& dip : r.dip_rad) dip = -dip;
    const Rot3 half_turn = Rot3::from_unit_quaternion(Vector4(0.0, 0.0, 0.0, 1.0));
    for (std::vector<Rot3>& part : r.nRb) {
      for (Rot3& R : part) R = half_turn * R;
    }
  }
  for (double& dip : r.dip_rad) dip = std::remainder(dip, 2.0 * M_PI);
  r.theta.dip_rad = r.dip_rad.front();
}

void fill_rival(Calibration& c, const RivalResult& r,
                const std::vector<const Recording*>& recordings) {
  c.parameters = r.theta;
  c.mag_names = recordings.front()->mag_names;
  c.strength_uT = std::cbrt(r.theta.mag.front().distortion.determinant());
  c.fit = r.fit;
  const std::vector<int> fields = fields_of(recordings);
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    if (c.fields.size() == std::size_t(fields[i])) {
      c.fields.push_back({recordings[i]->name, r.dip_rad[std::size_t(fields[i])]});
      c.trajectories.emplace_back().recording = recordings[i]->name;
    }
    TrajectoryEstimate& trajectory = c.trajectories.back();
    for (std::size_t k = 0; k < r.nRb[i].size(); ++k) {
      trajectory.t.push_back(r.steps[i][k].t);
      trajectory.nRb.push_back(r.nRb[i][k]);
    }
    c.samples += int(recordings[i]->gyr.size());
    c.nodes += int(r.nRb[i].size());
    if (recordings[i]->continues_previous) continue;
    for (const SetAside& s : recordings[i]->set_aside) {
      c.set_aside.push_back({recordings[i]->name, s});
    }
  }
  const auto mags = Eigen::Index(r.theta.mag.size());
  c.order = parameter_names(int(mags), int(c.fields.size()), ModelSpec{});
  VectorXd unit = VectorXd::Ones(Eigen::Index(c.order.size()));
  unit.tail(Eigen::Index(c.fields.size())).setConstant(1.0 / kDegree);
  c.covariance_model = unit.asDiagonal() * r.covariance * unit.asDiagonal();
  const double rates[2] = {recordings.front()->acc.rate_hz(),
                           recordings.front()->mag.front().rate_hz()};
  const double densities[2] = {c.noise.acc, c.noise.mag};
  for (std::size_t s = 0; s < 2; ++s) {
    const double sigma = densities[s] * std::sqrt(rates[s]);
    c.residuals[s == 0 ? 0 : 2] = {r.rms[s], r.lag[s], r.rms[s] * sigma};
  }
  // Innovations larger than the noise says: the sigmas grow by as much.
  const double excess = std::max({1.0, r.rms[0], r.rms[1]});
  c.covariance = excess * excess * c.covariance_model;
  for (std::size_t f = 0; f < c.fields.size(); ++f) {
    const Eigen::Index i = 6 + 12 * mags + Eigen::Index(f);
    c.fields[f].dip_sigma_rad = std::sqrt(c.covariance(i, i)) * kDegree;
    c.fields[f].dip_sigma_model_rad = std::sqrt(c.covariance_model(i, i)) * kDegree;
  }
  const Matrix3& D = c.parameters.mag.front().distortion;
  c.strength_sigma_uT = strength_sigma(D, c.strength_uT, c.covariance);
  c.strength_sigma_model_uT = strength_sigma(D, c.strength_uT, c.covariance_model);
}

}  // namespace

std::string to_string(RivalMethod method) { return method == RivalMethod::kKok ? "kok" : "wu"; }

RivalCalibration calibrate_by(const RivalOptions& rival, const std::vector<const Recording*>& given,
                              const CalibrationOptions& given_options) {
  const auto begin = std::chrono::steady_clock::now();
  const WellFormed well_formed(given);
  const CheckedRecordings checked(well_formed.get());
  const std::vector<const Recording*>& recordings = checked.get();
  const double start = thread_seconds();
  CalibrationOptions options = given_options;
  // The published methods trust the nominal bias of the gyroscope from the alignment on.
  options.initialization.trust_gyr_bias = rival.as_published;
  const Pipeline pipeline(recordings, options);
  const NoiseDensities noise = pipeline.starting_noise();
  RivalResult result = rival.method == RivalMethod::kKok
                           ? by_kok(rival, recordings, options, pipeline.guess(), noise)
                           : by_wu(rival, recordings, options, pipeline.guess(), noise);
  RivalCalibration out;
  out.seconds = thread_seconds() - start;
  out.method = to_string(rival.method) + (rival.as_published ? ", as published" : "");
  out.filter_runs = result.filter_runs;
  if (!result.covariance.allFinite() || !result.theta.mag.front().distortion.allFinite()) {
    throw NumericalError(out.method + ": the filter's numbers are not finite");
  }
  fix_rival_symmetries(result);
  Calibration& c = out.calibration;
  c.noise = noise;
  c.noise_given = options.noise.has_value();
  c.gravity = options.gravity;
  c.warnings = checked.warnings();
  fill_rival(c, result, recordings);
  out.not_estimated = {
      "the displacement of the hand: the sensor is taken to turn on the spot",
      "the noise: it is that given, or that at rest",
      "the magnetometer's lag and the gyroscope's scale errors",
      "the gyroscope's residuals: the filter takes its readings as they are",
      "robust sigmas: they are the model's, times the innovations' size where that is above 1",
      "left-out samples, halves and disturbances: none of these is looked at"};
  c.motion_reason = "Method: " + out.method + ". It assumes that the sensor only turns.";
  c.checks = {check_optimum(c.fit), check_accuracy(c)};
  judge(c, unknown_directions(c));
  judge_given_noise(c, recordings, options);
  judge_axes(c, check_mounting(recordings), options);
  judge_faults(c.trust, checked.faults());
  c.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

}  // namespace magimu

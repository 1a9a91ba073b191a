// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/calibrate.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <chrono>

#include "calibration/noise_estimation.h"
#include "calibration/parameter_names.h"
#include "calibration/rests.h"
#include "calibration/trust.h"
#include "calibration/uncertainty.h"
#include "recording/error.h"

namespace magimu {
namespace {

constexpr double kMinDuration = 5.0;     // s
constexpr double kCoarseRate = 12.0;     // nodes a second while the noise is being found
constexpr double kFullRate = 100.0;      // up to here every magnetometer sample is a node
constexpr double kDecimatedRate = 40.0;  // above, so many nodes a second at most
constexpr int kNoiseRounds = 8;
constexpr double kNoiseSettled = 0.01;  // relative change of every density
constexpr int kIntegrationRounds = 5;
constexpr double kWarmDamping = 1e-9;
constexpr double kBiasMoved = 1e-5;  // rad/s: integrate again

void check(const std::vector<const Recording*>& recordings) {
  if (recordings.empty()) throw InputError("", 0, 0, "no recording was given", "name at least one");
  for (const Recording* r : recordings) {
    if (r->mag.empty() || r->mag.front().size() < 10) {
      throw InputError(r->name, 0, 0, "there are no magnetometer samples",
                       "record the columns mag_x, mag_y, mag_z as well");
    }
    if (r->acc.size() < 10 || r->gyr.size() < 10 || r->duration_s() < kMinDuration) {
      throw InputError(r->name, 0, 0,
                       fmt::format("the recording lasts {:.1f} s, which is too short to calibrate",
                                   r->duration_s()),
                       "turn the sensor about all three axes for a minute or more");
    }
    if (r->mag.size() != recordings.front()->mag.size()) {
      throw InputError(r->name, 0, 0,
                       fmt::format("it has {} magnetometers, the first recording {}", r->mag.size(),
                                   recordings.front()->mag.size()),
                       "calibrate only recordings of one device together");
    }
  }
}

// The fit at one density of nodes: model, values, and what is needed to refit.
class Stage {
 public:
  Stage(const std::vector<const Recording*>& recordings, const CalibrationOptions& options,
        int every)
      : recordings_(recordings), options_(options), plans_(plan_nodes(recordings, every)) {}

  const std::vector<NodePlan>& plans() const { return plans_; }
  const RotationModel& model() const { return *model_; }
  const Result& result() const { return result_; }

  // Optimizes from values, integrating the gyroscope again while its bias moves.
  // warm: start is an optimum of a model much like this one.
  void fit(const Values& start, const NoiseDensities& noise, bool warm) {
    Values values = start;
    for (int round = 0; round < kIntegrationRounds; ++round) {
      const Vector3 bias = values.at<Vector3>(key::gyr_bias);
      model_ = build_rotation_model(recordings_, plans_, bias, noise, options_.gravity);
      OptimizerOptions optimizer = options_.optimizer;
      if (warm || round > 0) optimizer.initial_damping = kWarmDamping;
      Result result = LevenbergMarquardt(model_->graph, optimizer).optimize(values);
      if (round > 0) {  // one record of the whole fit
        result.cost_initial = result_.cost_initial;
        result.iterations += result_.iterations;
        result.seconds += result_.seconds;
        std::vector<IterationRecord> trace = std::move(result_.trace);
        for (IterationRecord record : result.trace) {
          record.iteration = int(trace.size());
          trace.push_back(record);
        }
        result.trace = std::move(trace);
      }
      result_ = std::move(result);
      values = result_.values;
      if ((values.at<Vector3>(key::gyr_bias) - bias).norm() < kBiasMoved) break;
    }
  }

  // Fits and re-estimates the noise in turn until it settles. gyr_known: leave the gyroscope's.
  NoiseDensities fit_noise(const Values& start, NoiseDensities noise, int rounds, bool gyr_known) {
    fit(start, noise, false);
    for (int round = 0; round < rounds; ++round) {
      NoiseDensities next = restricted_ml(noise, sums());
      if (gyr_known) next.gyr = noise.gyr;
      const double change =
          std::max({std::abs(next.acc / noise.acc - 1.0), std::abs(next.gyr / noise.gyr - 1.0),
                    std::abs(next.mag / noise.mag - 1.0)});
      noise = next;
      fit(Values(result_.values), noise, true);
      if (change < kNoiseSettled) break;
    }
    return noise;
  }

  SensorSums sums() const {
    LinearSystem system(model_->graph, result_.values);
    system.linearize(result_.values);
    const VectorXd scale = column_scale(system);
    const auto solver = make_linear_solver(options_.optimizer.backend);
    double damping = 0.0;
    while (!solver->factorize(system, scale, damping)) damping = std::max(1e-12, 10.0 * damping);
    return residual_sums(system, SensorRows(model_->graph, system), *solver, scale);
  }

 private:
  const std::vector<const Recording*>& recordings_;
  const CalibrationOptions& options_;
  std::vector<NodePlan> plans_;
  std::optional<RotationModel> model_;
  Result result_;
};

// The coarse stage's optimum carried to a finer plan's nodes: parameters as they are, each pose
// from the nearest coarse one by the gyroscope.
Values refine(const std::vector<const Recording*>& recordings, const Stage& coarse,
              const std::vector<NodePlan>& fine) {
  const Values& from = coarse.result().values;
  Values values;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const IntegratedRotation gyr(recordings[r]->gyr, from.at<Vector3>(key::gyr_bias));
    const NodePlan& plan = coarse.plans()[r];
    std::size_t k = 0;
    for (std::size_t i = 0; i < fine[r].t.size(); ++i) {
      const double t = fine[r].t[i];
      while (k + 1 < plan.t.size() && std::abs(plan.t[k + 1] - t) <= std::abs(plan.t[k] - t)) ++k;
      const Rot3 nearest = from.at<Rot3>(R(plan.first + int(k)));
      values.insert(R(fine[r].first + int(i)),
                    (nearest * gyr.between(plan.t[k], t)).normalized());
    }
  }
  for (const Values::Slot& s : from.slots()) {
    if (s.key.symbol == R(0).symbol) continue;
    if (s.type == VariableTraits<Vector3>::type()) values.insert(s.key, from.at<Vector3>(s.key));
    if (s.type == VariableTraits<Matrix3>::type()) values.insert(s.key, from.at<Matrix3>(s.key));
    if (s.type == VariableTraits<double>::type()) values.insert(s.key, from.at<double>(s.key));
  }
  return values;
}

// The two exact symmetries of the contract: cos(alpha) > 0, and det D > 0 of magnetometer 0.
void fix_symmetries(Values& values, int magnetometers, int recordings,
                    const std::vector<NodePlan>& plans) {
  const Rot3 half_turn = Rot3::from_unit_quaternion(Vector4(0.0, 0.0, 0.0, 1.0));
  const auto turn = [&](const NodePlan& plan) {
    for (int k = 0; k < int(plan.t.size()); ++k) {
      values.update(R(plan.first + k), half_turn * values.at<Rot3>(R(plan.first + k)));
    }
  };
  if (values.at<Matrix3>(key::distortion).determinant() < 0.0) {
    for (int m = 0; m < magnetometers; ++m) {
      values.update(key::distortion_of(m), Matrix3(-values.at<Matrix3>(key::distortion_of(m))));
    }
    for (int r = 0; r < recordings; ++r) {
      values.update(dip_of(r), -values.at<double>(dip_of(r)));
      turn(plans[std::size_t(r)]);
    }
  }
  for (int r = 0; r < recordings; ++r) {
    double dip = std::remainder(values.at<double>(dip_of(r)), 2.0 * M_PI);
    if (std::cos(dip) < 0.0) {
      dip = std::remainder(M_PI - dip, 2.0 * M_PI);
      turn(plans[std::size_t(r)]);
    }
    values.update(dip_of(r), dip);
  }
}

NoiseDensities rest_noise(const std::vector<const Recording*>& recordings) {
  NoiseDensities noise;
  for (const Recording* r : recordings) {
    const NoiseDensities rest = noise_at_rest(*r, find_rests(*r));
    noise.acc = std::max(noise.acc, rest.acc);
    noise.gyr = std::max(noise.gyr, rest.gyr);
    noise.mag = std::max(noise.mag, rest.mag);
  }
  return noise;
}

// Where the rests do not tell: values of ordinary parts, for the residuals to correct.
NoiseDensities completed(NoiseDensities noise, const Recording& first, const InitialGuess& guess) {
  if (noise.acc <= 0.0) noise.acc = 0.01;
  if (noise.gyr <= 0.0) noise.gyr = 1e-3;
  if (noise.mag <= 0.0) {
    noise.mag = std::max(guess.ellipsoid_rms_uT, 1e-3) / std::sqrt(first.mag.front().rate_hz());
  }
  return noise;
}

int automatic_node_every(const Recording& recording) {
  const double rate = recording.mag.front().rate_hz();
  return rate <= kFullRate ? 1 : int(std::ceil(rate / kDecimatedRate));
}

void fill_parameters(Calibration& c, const std::vector<const Recording*>& recordings,
                     const std::vector<NodePlan>& plans) {
  const Values& values = c.fit.values;
  c.parameters.acc_bias = values.at<Vector3>(key::acc_bias);
  c.parameters.gyr_bias = values.at<Vector3>(key::gyr_bias);
  c.parameters.dip_rad = values.at<double>(dip_of(0));
  c.parameters.mag.clear();
  for (int m = 0; m < int(recordings.front()->mag.size()); ++m) {
    c.parameters.mag.push_back({values.at<Matrix3>(key::distortion_of(m)),
                                values.at<Vector3>(key::mag_bias_of(m))});
  }
  c.mag_names = recordings.front()->mag_names;
  c.strength_uT = std::cbrt(c.parameters.mag.front().distortion.determinant());
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    TrajectoryEstimate trajectory;
    trajectory.recording = recordings[r]->name;
    trajectory.t = plans[r].t;
    for (int k = 0; k < int(plans[r].t.size()); ++k) {
      trajectory.nRb.push_back(values.at<Rot3>(R(plans[r].first + k)));
    }
    c.trajectories.push_back(std::move(trajectory));
    c.samples += int(recordings[r]->gyr.size());
    c.nodes += int(plans[r].t.size());
    FieldEstimate field;
    field.recording = recordings[r]->name;
    field.dip_rad = values.at<double>(dip_of(int(r)));
    c.fields.push_back(field);
  }
}

void fill_residuals(Calibration& c, const Stage& stage) {
  const SensorSums sums = stage.sums();
  const double nodes_per_s =
      c.nodes / std::max(1e-9, c.trajectories.front().t.back() - c.trajectories.front().t.front());
  const double densities[3] = {c.noise.acc, c.noise.gyr, c.noise.mag};
  for (std::size_t s = 0; s < 3; ++s) {
    const double left = std::max(1.0, sums.rows[s] - sums.absorbed[s]);
    c.residuals[s].rms = std::sqrt(sums.squares[s] / left);
    c.residuals[s].lag1 = sums.lag1[s];
    c.residuals[s].rms_unit = c.residuals[s].rms * densities[s] * std::sqrt(nodes_per_s);
  }
}

}  // namespace

Calibration calibrate(const Recording& recording, const CalibrationOptions& options) {
  return calibrate(std::vector<const Recording*>{&recording}, options);
}

Calibration calibrate(const std::vector<const Recording*>& recordings,
                      const CalibrationOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  check(recordings);
  const int magnetometers = int(recordings.front()->mag.size());
  const int count = int(recordings.size());
  const double mag_rate = recordings.front()->mag.front().rate_hz();

  Calibration c;
  c.gravity = options.gravity;
  c.noise_given = options.noise.has_value();
  c.node_every =
      options.node_every > 0 ? options.node_every : automatic_node_every(*recordings.front());
  const InitialGuess guess = initialize(recordings, options.initialization);
  const NoiseDensities rested = rest_noise(recordings);
  c.noise = options.noise.value_or(completed(rested, *recordings.front(), guess));

  // Few nodes first: most iterations, and the search for the noise, are cheap there.
  const int coarse_every = std::max(c.node_every, int(std::ceil(mag_rate / kCoarseRate)));
  Stage coarse(recordings, options, coarse_every);
  const Values first = initial_values(recordings, coarse.plans(), guess);
  if (c.noise_given) {
    coarse.fit(first, c.noise, false);
  } else {
    c.noise = coarse.fit_noise(first, c.noise, kNoiseRounds, rested.gyr > 0.0);
  }
  Stage fine(recordings, options, c.node_every);
  Values refined = refine(recordings, coarse, fine.plans());
  fix_symmetries(refined, magnetometers, count, fine.plans());
  fine.fit(refined, c.noise, true);

  c.fit = fine.result();
  fill_parameters(c, recordings, fine.plans());
  fill_residuals(c, fine);
  fill_uncertainty(c, fine.model().graph, options);
  judge(c, recordings);
  c.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return c;
}

}  // namespace magimu

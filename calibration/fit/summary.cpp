// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/summary.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibration/fit/moved_by_blocks.h"
#include "calibration/fit/uncertainty.h"
#include "calibration/model/extension.h"
#include "calibration/model/parameter_names.h"
#include "solvers/lanes/global_covariance.h"

namespace magimu {
namespace {

void fill_parameters(Calibration& c, const std::vector<const Recording*>& recordings,
                     const Stage& stage) {
  const Values& values = c.fit.values;
  const bool moving = is_moved(c.motion);
  c.parameters.acc_bias = values.at<Vector3>(key::acc_bias);
  c.parameters.gyr_bias = values.at<Vector3>(key::gyr_bias);
  c.parameters.dip_rad = values.at<double>(dip_of(0));
  c.parameters.mag.clear();
  c.mag_names = recordings.front()->mag_names;
  for (int m = 0; m < int(recordings.front()->mag.size()); ++m) {
    c.parameters.mag.push_back(
        {values.at<Matrix3>(key::distortion_of(m)), values.at<Vector3>(key::mag_bias_of(m))});
    c.magnetometers.push_back({.noise = mag_density(stage.spec(), m)});
    if (!stage.spec().mag_time_offset) continue;
    if (m == 0) c.effects.push_back({"mag_time_offset", {}});
    c.effects.back().parameters.push_back(
        {time_offset_name(m), "s", values.at<double>(key::mag_time_offset_of(m))});
  }
  if (stage.spec().gyr_matrix) {
    const auto S = values.at<GyroMatrix>(key::gyr_matrix);
    ActiveEffect effect{"gyro_scale_misalignment", {}};
    for (int e = 0; e < 9; ++e) {
      effect.parameters.push_back({gyr_matrix_name(e), "1", S[e]});
    }
    c.effects.push_back(effect);
  }
  const std::vector<std::vector<Key>> keys = effect_keys(stage.spec().effects);
  for (std::size_t e = 0; e < keys.size(); ++e) {
    const Effect& effect = *stage.spec().effects[e];
    ActiveEffect active{effect.name(), {}};
    for (int i = 0; i < effect.size(); ++i) {
      active.parameters.push_back({effect_parameter_name(effect, i),
                                   effect.description().parameters[std::size_t(i)].unit,
                                   values.at<double>(keys[e][std::size_t(i)])});
    }
    c.effects.push_back(active);
  }
  c.strength_uT = std::cbrt(c.parameters.mag.front().distortion.determinant());
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const NodePlan& plan = stage.plans()[r];
    // One a recording, whatever parts it is calibrated in.
    if (c.trajectories.size() == std::size_t(plan.field)) {
      c.trajectories.emplace_back().recording = recordings[r]->name;
      FieldEstimate& field = c.fields.emplace_back();
      field.recording = recordings[r]->name;
      field.dip_rad = values.at<double>(dip_of(plan.field));
      if (c.motion == MotionModel::kHandHeld) {
        const auto arm = values.at<Vector3>(key::lever_arm_of(plan.field));
        c.lever_arms.push_back({recordings[r]->name, arm, {}});
      }
    }
    TrajectoryEstimate& trajectory = c.trajectories.back();
    trajectory.t.insert(trajectory.t.end(), plan.t.begin(), plan.t.end());
    for (int k = 0; k < int(plan.t.size()); ++k) {
      trajectory.nRb.push_back(values.at<Rot3>(R(plan.first + k)));
      if (!moving) continue;
      trajectory.v.push_back(values.at<Vector3>(V(plan.first + k)));
      trajectory.p.push_back(values.at<Vector3>(P(plan.first + k)));
    }
    c.samples += int(recordings[r]->gyr.size());
    if (!recordings[r]->continues_previous) {  // parts have it of the whole
      for (const SetAside& s : recordings[r]->set_aside) {
        c.set_aside.push_back({recordings[r]->name, s});
      }
    }
    c.nodes += int(plan.t.size());
  }
}

Calibration without_uncertainty(const std::vector<const Recording*>& recordings, const Stage& stage,
                                const CalibrationOptions& options) {
  Calibration c;
  c.fit = stage.result();
  c.motion = stage.spec().motion;
  if (c.motion == MotionModel::kTravelling) c.speed_mps = stage.spec().speed_mps;
  if (c.motion == MotionModel::kHandHeld) c.reach_m = stage.spec().reach_m;
  if (is_moved(c.motion)) c.acc_jitter = stage.spec().acc_jitter;
  c.noise = stage.spec().noise;
  c.noise_given = options.noise.has_value();
  c.gravity = options.gravity;
  fill_parameters(c, recordings, stage);
  return c;
}

Calibration with_uncertainty(const std::vector<const Recording*>& recordings, const Optimum& at,
                             const Marginals& marginals, const CalibrationOptions& options,
                             MatrixXd& moved) {
  Calibration c = without_uncertainty(recordings, at.stage, options);
  fill_uncertainty(c, at, marginals, options.block_s, moved);
  for (std::size_t r = 0; r < c.lever_arms.size(); ++r) {
    c.lever_arms[r].covariance = marginals.determined_covariance({key::lever_arm_of(int(r))});
  }
  return c;
}

}  // namespace

void fill_residuals(Calibration& c, const std::vector<NodePlan>& plans, const SensorSums& sums) {
  const NodePlan& longest =
      *std::ranges::max_element(plans, {}, [](const NodePlan& plan) { return plan.t.size(); });
  const std::vector<double>& t = longest.t;
  const double nodes_per_s = double(t.size()) / std::max(1e-9, t.back() - t.front());
  const double densities[3] = {c.noise.acc, c.noise.gyr, c.noise.mag};
  for (std::size_t s = 0; s < 3; ++s) {
    c.residuals[s].rms = sums.rms(Sensor(s));
    c.residuals[s].lag1 = sums.lag1[s];
    c.residuals[s].rms_unit = c.residuals[s].rms * densities[s] * std::sqrt(nodes_per_s);
  }
  if (c.magnetometers.size() == 1) c.magnetometers.front().residuals = c.residuals[2];
  if (c.magnetometers.size() < 2 || sums.magnetometers.size() != c.magnetometers.size()) return;
  std::vector<double> units;
  for (std::size_t m = 0; m < c.magnetometers.size(); ++m) {
    MagnetometerRecord& own = c.magnetometers[m];
    const MagnetometerSums& of = sums.magnetometers[m];
    own.residuals = {of.rms(), of.lag1, of.rms() * own.noise * std::sqrt(nodes_per_s)};
    units.push_back(own.residuals.rms_unit);
  }
  std::ranges::nth_element(units, units.begin() + std::ptrdiff_t(units.size() / 2));
  c.residuals[2].rms_unit = units[units.size() / 2];
}

Calibration summarize(const std::vector<const Recording*>& recordings, const Stage& stage,
                      const CalibrationOptions& options) {
  return summarize(recordings, Optimum(stage), options);
}

Calibration summarize(const std::vector<const Recording*>& recordings, const Optimum& at,
                      const CalibrationOptions& options) {
  MatrixXd moved;
  return summarize(recordings, at, options, moved);
}

Calibration summarize(const std::vector<const Recording*>& recordings, const Optimum& at,
                      const CalibrationOptions& options, MatrixXd& moved) {
  const Marginals marginals(at.system, at.stage.result().values, options.optimizer.backend);
  Calibration c = with_uncertainty(recordings, at, marginals, options, moved);
  fill_residuals(c, at.stage.plans(),
                 residual_sums(at.system, at.rows, marginals.solver(), marginals.scale()));
  return c;
}

Calibration summarize_parameters(const std::vector<const Recording*>& recordings, const Optimum& at,
                                 const CalibrationOptions& options) {
  const Marginals marginals(at.system, at.stage.result().values, options.optimizer.backend);
  MatrixXd moved;
  return with_uncertainty(recordings, at, marginals, options, moved);
}

Calibration summarize_model(const std::vector<const Recording*>& recordings, const Stage& stage,
                            const CalibrationOptions& options) {
  const int magnetometers = int(recordings.front()->mag.size()), fields = field_count(recordings);
  const std::vector<Key> keys = parameter_keys(magnetometers, fields, stage.spec());
  const std::optional<MatrixXd> P = global_covariance(stage.graph(), stage.result().values, keys);
  if (!P) return summarize_parameters(recordings, Optimum(stage), options);
  Calibration c = without_uncertainty(recordings, stage, options);
  c.order = parameter_names(magnetometers, fields, stage.spec());
  fill_covariance(c, *P, *P);
  return c;
}

}  // namespace magimu

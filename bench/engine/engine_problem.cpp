// SPDX-License-Identifier: BSD-3-Clause
// Simulated recordings as graphs: engine_problem.h.
#include "bench/engine/engine_problem.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "calibration/pipeline.h"

namespace magimu {
namespace {

EngineCase rotation(double rate_hz) {
  EngineCase c;
  c.family = "rotation";
  c.name = fmt::format("rotation, {:g} Hz, 322 s", rate_hz);
  c.simulated.rate_hz = rate_hz;
  return c;
}

EngineCase lasting(double duration_s) {
  EngineCase c;
  c.family = "long";
  c.name = fmt::format("rotation, 80 Hz, {:g} s", duration_s);
  c.simulated.motion = SimulatedMotion::kHand;
  c.simulated.duration_s = duration_s;
  return c;
}

EngineCase array() {
  EngineCase c;
  c.family = "array";
  c.name = "30 magnetometers, 62.5 Hz, 322 s";
  c.simulated.rate_hz = 62.5;
  c.simulated.magnetometers = 30;
  return c;
}

EngineCase hand_held(int node_every) {
  EngineCase c;
  c.family = "hand_held";
  c.name = fmt::format("hand-held, 286 Hz, 170 s, {}",
                       node_every == 1 ? "every sample a node" : "nodes as by default");
  c.motion = MotionModel::kHandHeld;
  c.node_every = node_every;
  c.simulated.motion = SimulatedMotion::kHandHeld;
  c.simulated.rate_hz = 286.0;
  c.simulated.duration_s = 170.0;
  return c;
}

double sample_sigma(double density, const VectorSeries& series) {
  return density * std::sqrt(series.rate_hz());
}

RotationData textbook_data(const Recording& recording, const ModelSpec& spec, double dt_s) {
  RotationData data;
  data.acc = recording.acc.v;
  data.gyr = recording.gyr.v;
  data.mag = recording.mag.front().v;
  data.dt_s = dt_s;
  data.g_n = gravity_n(spec.gravity);
  data.acc_sigma = sample_sigma(spec.noise.acc, recording.acc);
  data.gyr_sigma = spec.noise.gyr / std::sqrt(dt_s);
  data.mag_sigma = sample_sigma(spec.noise.mag, recording.mag.front());
  return data;
}

RotationUnknowns textbook_start(const Values& values, int nodes) {
  RotationUnknowns x;
  for (int k = 0; k < nodes; ++k) x.nRb.push_back(values.at<Rot3>(R(k)));
  x.acc_bias = values.at<Vector3>(key::acc_bias);
  x.gyr_bias = values.at<Vector3>(key::gyr_bias);
  x.mag_bias = values.at<Vector3>(key::mag_bias);
  x.distortion = values.at<Matrix3>(key::distortion);
  x.dip_rad = values.at<double>(key::dip);
  return x;
}

}  // namespace

std::vector<EngineCase> engine_cases(const std::string& family) {
  std::vector<EngineCase> all;
  for (const double rate_hz : {10.0, 20.0, 40.0, 80.0}) all.push_back(rotation(rate_hz));
  for (const double s : {10.0, 30.0, 100.0, 300.0, 1000.0, 3600.0}) all.push_back(lasting(s));
  all.push_back(array());
  for (const int node_every : {0, 1}) all.push_back(hand_held(node_every));
  if (family == "all") return all;
  std::erase_if(all, [&](const EngineCase& c) { return c.family != family; });
  if (all.empty()) {
    throw std::invalid_argument("there is no case '" + family +
                                "': rotation, long, array, hand_held or all");
  }
  return all;
}

EngineProblem make_problem(const EngineCase& c) {
  // One thread only: processes are forked later, and threads do not survive that.
  const tbb::global_control serial(tbb::global_control::max_allowed_parallelism, 1);
  const Simulation s = simulate(c.simulated);
  const std::vector<const Recording*> recordings = {&s.recording};
  CalibrationOptions options;
  options.noise = s.truth.noise;
  options.gravity = s.truth.gravity;
  options.node_every = c.node_every;
  const Pipeline pipeline(recordings, options);
  const InitialGuess& guess = pipeline.guess();
  ModelSpec spec;
  spec.motion = c.motion;
  spec.noise = s.truth.noise;
  spec.gravity = s.truth.gravity;
  spec.gyr_bias = guess.parameters.gyr_bias;
  const std::vector<NodePlan> plans = plan_nodes(recordings, pipeline.node_every());

  EngineProblem out;
  out.name = c.name;
  out.nodes = int(plans.front().t.size());
  out.graph = build_model(recordings, plans, spec);
  out.start = initial_values(recordings, plans, guess, c.motion);
  if (c.motion == MotionModel::kRotation && c.simulated.magnetometers == 1 &&
      pipeline.node_every() == 1) {
    out.textbook_data = textbook_data(s.recording, spec, 1.0 / c.simulated.rate_hz);
    out.textbook_start = textbook_start(out.start, out.nodes);
  }
  return out;
}

Values to_values(const Values& start, const RotationUnknowns& unknowns) {
  Values values = start;
  for (std::size_t k = 0; k < unknowns.nRb.size(); ++k) values.update(R(int(k)), unknowns.nRb[k]);
  values.update(key::acc_bias, unknowns.acc_bias);
  values.update(key::gyr_bias, unknowns.gyr_bias);
  values.update(key::mag_bias, unknowns.mag_bias);
  values.update(key::distortion, unknowns.distortion);
  values.update(key::dip, unknowns.dip_rad);
  return values;
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/motion_finding.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/choose_motion.h"
#include "calibration/general_dependence.h"
#include "calibration/rests.h"
#include "calibration/sensor_rows.h"
#include "diagnosis/held_out_nll.h"
#include "diagnosis/stored_model.h"
#include "recording/median.h"

namespace magimu {
namespace {

constexpr double kCalm = 1.15;  // accelerometer noise in motion over that at rest
constexpr double kCalmColour = 0.15;
constexpr double kRestColour = 0.2;  // correlation of neighbouring nodes
constexpr double kMoreInMotion = 1.2, kMoreThanColour = 1.3;
constexpr double kMostOfIt = 0.5;  // of the misfit, for an effect to be tried in its stead

// The accelerometer's residual under pure rotation.
struct Restlessness {
  double excess = 1.0, colour = 0.0;
  double rows = 0.0;
  double squares = 0.0;  // whitened, beyond those of noise as at rest
};

// The same in rests, about each rest's mean: what is there, too, no motion has made.
struct AtRest {
  double motion_over_rest = INFINITY;  // median size of the residual: tails do not count
  double colour = 0.0;                 // correlation of neighbouring nodes
};

// Of each node; -1: in motion.
std::vector<int> rests_of_nodes(const Stage& stage, const std::vector<const Recording*>& recordings,
                                int& rests) {
  std::vector<int> out;
  rests = 0;
  for (std::size_t p = 0; p < recordings.size(); ++p) {
    const std::vector<TimeSpan> spans = find_rests(*recordings[p]);
    for (const double t : stage.plans()[p].t) {
      int rest = -1;
      for (std::size_t s = 0; s < spans.size(); ++s) {
        if (t >= spans[s].begin_s && t <= spans[s].end_s) rest = rests + int(s);
      }
      out.push_back(rest);
    }
    rests += int(spans.size());
  }
  return out;
}

AtRest at_rest(const Stage& rotation, const std::vector<const Recording*>& recordings) {
  const Values& values = rotation.result().values;
  const LinearSystem system(rotation.graph(), values);
  const VectorXd r = system.whitened_residuals(values);
  const SensorRows rows(rotation.graph(), system);
  int rests = 0;
  const std::vector<int> rest_of = rests_of_nodes(rotation, recordings, rests);
  std::vector<double> moving;
  std::vector<std::vector<double>> still(std::size_t(3 * rests));  // by rest and axis
  int axis = 0;
  for (int i = 0; i < system.rows(); ++i) {
    if (rows.sensor[std::size_t(i)] != Sensor::kAcc) continue;
    const int rest = rest_of[std::size_t(rows.node[std::size_t(i)])];
    if (rest < 0) {
      moving.push_back(std::abs(r[i]));
    } else {
      still[std::size_t(3 * rest + axis)].push_back(r[i]);
    }
    axis = (axis + 1) % 3;
  }
  std::vector<double> sizes;
  double squares = 0.0, products = 0.0;
  for (std::vector<double>& x : still) {
    double mean = 0.0;
    for (const double v : x) mean += v / double(x.size());
    for (std::size_t k = 0; k < x.size(); ++k) {
      x[k] -= mean;
      sizes.push_back(std::abs(x[k]));
      squares += x[k] * x[k];
      if (k > 0) products += x[k] * x[k - 1];
    }
  }
  AtRest out;
  if (sizes.size() < 60 || moving.empty() || squares <= 0.0) return out;
  out.motion_over_rest = median(moving) / std::max(median(sizes), 1e-300);
  out.colour = products / squares;
  return out;
}

Restlessness restlessness(const Stage& rotation, double rest_acc) {
  const SensorSums sums = rotation.sums();
  Restlessness out;
  out.colour = sums.lag1[std::size_t(Sensor::kAcc)];
  out.rows = sums.rows[std::size_t(Sensor::kAcc)];
  const double rms = sums.rms(Sensor::kAcc);
  if (rest_acc > 0.0) out.excess = rotation.spec().noise.acc * rms / rest_acc;
  out.squares = out.rows * rms * rms * (1.0 - 1.0 / std::pow(std::max(1.0, out.excess), 2));
  return out;
}

// What the accelerometer measured beside gravity and bias, RMS of single samples, m/s^2.
double acceleration_rms(const Stage& rotation, const Recording& recording) {
  const double noise = rotation.spec().noise.acc * rotation.sums().rms(Sensor::kAcc);
  const std::vector<double>& t = rotation.plans().front().t;
  const double nodes_per_s = double(t.size()) / std::max(1e-9, recording.duration_s());
  return noise * std::sqrt(nodes_per_s) * std::sqrt(3.0);
}

Finding motion_finding(const Stage& rotation, const Stage& moving, const Restlessness& restless,
                       const Recording& recording) {
  // Velocity and position make likelihoods under the two models incomparable. What can be compared
  // is what the accelerometer costs if its residual under pure rotation is noise as at rest, and if
  // it is as large as it is: no parameter has been fitted to that.
  const double excess2 = restless.excess * restless.excess;
  const double after = sum_of(held_out_nll(moving));
  const double before =
      after + 0.5 * restless.rows * std::max(0.0, excess2 - 1.0 - std::log(excess2));
  const double rms = acceleration_rms(rotation, recording);
  Finding f;
  f.effect = "linear_acceleration";
  f.channel = "acc";
  f.sentence = fmt::format(
      "The hand moved the sensor: it accelerated by {:.2g} m/s^2 (RMS), {:.1f} times what the "
      "accelerometer's noise explains; velocity and position are part of the model from here on.",
      rms, restless.excess);
  f.parameters = {{"acceleration_rms", rms, rms / std::sqrt(restless.rows), "m/s^2"}};
  f.p_value = std::pow(
      10.0, std::max(-300.0, log10_chi_square_tail(restless.rows * excess2, restless.rows)));
  f.probability = 1.0;
  f.gain = {.heldout_nll_before = before,
            .heldout_nll_after = after,
            .bic_delta = -restless.rows * (excess2 - 1.0),
            .residual_rms_before = restless.excess,
            .residual_rms_after = moving.sums().rms(Sensor::kAcc)};
  f.confusable_with = {{"lever_arm", "a sensor that turns about a point beside it is moved, too",
                        "turn about a fixed point"}};
  return f;
}

// Does what the accelerometer leaves follow the way the sensor is held and turned? A hand does not.
// (Products of the rate are left out: a sensor swung about a point beside it is moved so.)
bool follows_the_attitude(const std::vector<const Recording*>& recordings, const Stage& rotation,
                          double misfit) {
  auto dependences = general_dependences(true);
  std::erase_if(dependences, [](const auto& e) { return e->channel() != Channel::kAcc; });
  const Scan scan(recordings, rotation, dependences);
  return std::ranges::any_of(
      scan.scores(), [&](const Score& s) { return s.statistic - s.dof > kMostOfIt * misfit; });
}

}  // namespace

Stage choose_motion_model(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                          const DiagnosisOptions& options, Extender& extender, Diagnosis& d) {
  if (options.base) {
    const Stage stage = stored_model(*options.base, recordings, pipeline, d.notes);
    extender.set_base(stage);
    return stage;
  }
  if (options.motion != MotionModel::kAuto) {
    const Stage stage = pipeline.with_fixed_symmetries(pipeline.coarse_fit(options.motion));
    extender.set_base(stage);
    return stage;
  }
  const double rest_acc = pipeline.rest_noise().acc;
  const Stage rotation =
      pipeline.with_fixed_symmetries(pipeline.coarse_fit(MotionModel::kRotation));
  extender.set_base(rotation);
  const Stage moving = pipeline.with_fixed_symmetries(pipeline.coarse_fit(MotionModel::kHandHeld));
  // Coloured noise and heavy tails look like a motion, but they are there in rests, too.
  const AtRest rest = at_rest(rotation, recordings);
  const double more = rest.colour > kRestColour ? kMoreThanColour : kMoreInMotion;
  if (rest.motion_over_rest < more ||
      choose_motion(rotation, moving, rest_acc).motion == MotionModel::kRotation) {
    return rotation;
  }

  const Restlessness restless = restlessness(rotation, rest_acc);
  const Scan scan(recordings, rotation, extender.candidates(rotation));
  const bool other = std::any_of(scan.scores().begin(), scan.scores().end(), [&](const Score& s) {
    return log10_chi_square_tail(s.statistic, s.dof) < extender.log10_level() &&
           s.statistic > kMostOfIt * restless.squares;
  });
  if (other) {
    const Diagnosis before = d;
    extender.extend(rotation);
    const Restlessness now = restlessness(extender.stage(), rest_acc);
    if (now.excess < kCalm && now.colour < kCalmColour) return extender.stage();
    d = before;
  }
  if (follows_the_attitude(recordings, rotation, restless.squares)) return rotation;
  d.findings.push_back(motion_finding(rotation, moving, restless, *recordings.front()));
  return moving;
}

}  // namespace magimu

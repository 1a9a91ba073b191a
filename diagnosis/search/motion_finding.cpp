// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/motion_finding.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "calibration/fit/choose_motion.h"
#include "calibration/scan/general_dependence.h"
#include "calibration/scan/testable.h"
#include "calibration/travelling.h"
#include "diagnosis/held/held_out_nll.h"
#include "diagnosis/search/scan_options.h"
#include "diagnosis/search/shapes/slow_motion.h"
#include "diagnosis/search/stored_model.h"
#include "factors/effects/catalogue.h"
#include "graph/numerical_error.h"
#include "statistics/quantiles.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kCalm = 1.15;         // accelerometer noise in motion over that at rest
constexpr double kCalmColour = 0.15;   // correlation of neighbours in the accelerometer's residual
constexpr double kMoreInMotion = 1.2;  // the residuals' median in motion over that at rest
constexpr std::size_t kFewestStill = 60;  // residuals at rest, one an axis: 20 nodes tell a median
constexpr double kMostOfIt = 0.5;  // share of the misfit: an effect that explains so much is tried
constexpr double kSomeOfIt = 0.1;  // share of the accelerometer's misfit: each takes at least this
constexpr double kClearlyMore = 4.5;  // standard deviations: slow power over that at rest
constexpr double kSlowSigmas = 3.6, kLeastSlow = 0.1;  // sigmas; logarithm of the slow power
constexpr double kTheirSigmas = 2.5;                   // sigmas: the same of another sensor
constexpr double kOfVertical = 1.0 / 6.0;  // of the whole: half of what a hand moves up and down
constexpr double kOverColour = 1.4;        // standard deviations: beyond coloured noise

// The accelerometer's residual under pure rotation.
struct Restlessness {
  double excess = 1.0, colour = 0.0;
  double rows = 0.0;
  double left = 0.0, squares = 0.0;  // whitened squares: all; those beyond the noise
};

// Are the residuals larger in motion than in the rests (about the mean of each), and is more of
// them slow? If not, they do not come from a motion. Sizes are compared by the median, so that
// tails do not count. True without rests.
bool more_in_motion(const NodeResiduals& r) {
  std::vector<double> moving, still;
  const auto add = [](std::vector<double>& to, const Vector3& x) {
    for (const double v : x) to.push_back(std::abs(v));
  };
  for (const auto& piece : r.moving) {
    for (const Vector3& x : piece) add(moving, x);
  }
  for (const auto& piece : r.still) {
    Vector3 mean = Vector3::Zero();
    for (const Vector3& x : piece) mean += x / double(piece.size());
    for (const Vector3& x : piece) add(still, x - mean);
  }
  if (still.size() < kFewestStill || moving.empty()) return true;
  const SlowPower slow = slow_power(r);
  return median(moving) > kMoreInMotion * median(still) &&
         (slow.unknowns == 0.0 || slow.over_rest > kClearlyMore);
}

Restlessness restlessness(const Stage& rotation, const AccNoise& noise) {
  const SensorSums sums = rotation.sums();
  Restlessness out;
  out.colour = sums.lag1[std::size_t(Sensor::kAcc)];
  out.rows = sums.rows[std::size_t(Sensor::kAcc)];
  const double rms = sums.rms(Sensor::kAcc);
  out.excess = rotation.spec().noise.acc * rms / noise.density;
  out.left = out.rows * rms * rms;
  // Where no rest shows the noise, the correlation of neighbours tells what is not noise.
  out.squares = out.left * std::max(out.colour, 1.0 - 1.0 / std::pow(std::max(1.0, out.excess), 2));
  return out;
}

// How much a moved sensor accelerates from node to node, m/s^2, RMS of the vector, by the
// velocities of the fit without what the accelerometer's noise makes of them; and its standard
// deviation.
struct Acceleration {
  double rms, sigma;
};
Acceleration acceleration_of(const Stage& moving) {
  const Values& values = moving.result().values;
  double squares = 0.0, noise = 0.0, seconds = 0.0, unknowns = 0.0;
  for (const NodePlan& plan : moving.plans()) {
    for (std::size_t k = 1; k < plan.t.size(); ++k) {
      const double dt = plan.t[k] - plan.t[k - 1];
      const Vector3 dv = values.at<Vector3>(V(plan.first + int(k))) -
                         values.at<Vector3>(V(plan.first + int(k) - 1));
      squares += dv.squaredNorm() / dt;
      noise += 3.0 * std::pow(moving.spec().noise.acc, 2);
      seconds += dt;
      unknowns += 3.0;
    }
  }
  const double all = squares / seconds, of_noise = noise / seconds;
  const double rms = std::sqrt(std::max(all - of_noise, of_noise / std::sqrt(unknowns)));
  return {rms, all / (rms * std::sqrt(2.0 * unknowns))};
}

// "... it accelerated by 0.5 m/s^2 (RMS)" and a rest that says why that is believed.
constexpr std::string_view kUnit = " m/s^2 (RMS)";
void tell_acceleration(const Stage& moving, Finding& f) {
  const Acceleration a = acceleration_of(moving);
  f.parameters = {{"acceleration_rms", a.rms, a.sigma, "m/s^2"}};
  const std::size_t unit = f.sentence.find(kUnit);
  if (unit == std::string::npos) return;
  f.sentence = fmt::format("The hand moved the sensor: it accelerated by {:.2g}", a.rms) +
               f.sentence.substr(unit);
}

// Likelihoods under the two models cannot be compared, since one has velocities and positions.
// Instead the cost of the accelerometer's residual under pure rotation is compared for noise as at
// rest and for noise as large as the residual. unknowns: number of coefficients of the residual;
// times: their mean square over that at rest. why: the sentence behind how much it accelerated.
Finding finding_of_motion(const Stage& moving, const std::string& why, double unknowns,
                          double times, double residual_before) {
  const double after = sum_of(held_out_nll(moving));
  Finding f;
  f.effect = "linear_acceleration";
  f.channel = "acc";
  f.sentence = std::string(kUnit) + why;
  tell_acceleration(moving, f);
  f.probability = 1.0;
  f.gain = {
      .heldout_nll_before = after + 0.5 * unknowns * std::max(0.0, times - 1.0 - std::log(times)),
      .heldout_nll_after = after,
      .bic_delta = -unknowns * (times - 1.0),
      .residual_rms_before = residual_before,
      .residual_rms_after = moving.sums().rms(Sensor::kAcc)};
  f.confusable_with = {{"lever_arm", "a sensor that turns about a point beside it is moved, too",
                        "turn about a fixed point"}};
  return f;
}

// Rewrites the finding where no rest shows the noise. Its evidence is then the correlation of
// neighbours, which white noise of any size does not have.
void tell_by_colour(const Restlessness& restless, Finding& f) {
  const double alike = 1.0 - std::pow(std::min(restless.colour, 0.999), 2);
  const double nats = -0.5 * restless.rows * std::log(alike);
  f.gain.heldout_nll_before = f.gain.heldout_nll_after + nats;
  f.gain.bic_delta = -2.0 * nats;
  f.gain.residual_rms_before = 1.0 / std::sqrt(alike);
  f.p_value = std::max(1e-300, normal_tail(restless.colour * std::sqrt(restless.rows)));
}

std::string why_moved(const Restlessness& restless) {
  if (restless.excess >= kCalm) {
    return ", more than the accelerometer's noise explains; velocity and position are part of the "
           "model from here on.";
  }
  return fmt::format(
      ". No rest shows the accelerometer's noise, but what it reads beside gravity is no white "
      "noise (correlation of neighbours {:.2f}); velocity and position are part of the model from "
      "here on.",
      restless.colour);
}

Finding motion_finding(const Stage& moving, const Restlessness& restless) {
  const double times = restless.excess * restless.excess;
  Finding f = finding_of_motion(moving, why_moved(restless), restless.rows, times, restless.excess);
  f.p_value =
      std::pow(10.0, std::max(-300.0, log10_chi_square_tail(restless.rows * times, restless.rows)));
  if (restless.excess < kCalm) tell_by_colour(restless, f);
  return f;
}

Finding small_motion_finding(const Stage& rotation, const Stage& moving, const SlowPower& slow) {
  const double times = std::exp(slow.log_ratio);
  const std::string why = fmt::format(
      "; slower than 1.5 Hz the accelerometer reads {:.2g} times as much beside gravity as its "
      "noise explains. Velocity and position are part of the model from here on.",
      std::sqrt(times));
  Finding f =
      finding_of_motion(moving, why, slow.unknowns, times, rotation.sums().rms(Sensor::kAcc));
  f.p_value = std::min(1.0, normal_tail(slow.z()) * kHandsBands * double(count_looked_for()));
  return f;
}

bool is_calm(const Restlessness& r) { return r.excess < kCalm && r.colour < kCalmColour; }

// Can known causes explain nearly all of the accelerometer's residual instead of a moved hand? They
// enter one after another, each time the one that takes most of that residual. (Most of what a
// cause explains may be another sensor's misfit.) Whether they are the causes is decided elsewhere.
// A change whose times, or a source whose place, is known roughly yet need take most of it only.
bool has_rivals(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                const Extender& extender, const Stage& rotation, Restlessness now,
                const AccNoise& noise) {
  const double least = kSomeOfIt * now.squares;
  Stage stage = rotation;
  while (!is_calm(now) && !(now.squares < least)) {
    std::optional<Stage> best;
    Restlessness of_best{.left = now.left - least};
    for (const Option& o : scan_options(recordings, stage, extender.candidates(stage))) {
      const bool shows =
          o.rank < extender.log10_level() && o.score.statistic > kMostOfIt * now.squares;
      if (!shows) continue;
      ModelSpec spec = stage.spec();
      spec.effects.push_back(o.effect);
      const VectorXd& start = o.start.size() > 0 ? o.start : o.score.theta;
      auto with = attempt([&] { return pipeline.refit_with_same_noise(stage, spec, start); });
      if (!with) continue;
      const Restlessness its = restlessness(*with, noise);
      const bool roughly = is_change(o.effect->name()) || o.effect->name() == "stationary_source";
      if (roughly && its.left < now.left - kMostOfIt * now.squares) return true;
      if (!(its.left < of_best.left)) continue;
      of_best = its;
      best = std::move(with);
    }
    if (!best) return false;
    stage = *std::move(best);
    now = of_best;
  }
  return true;
}

// What most of the accelerometer's residual depends on.
struct Dependence {
  bool on_attitude = false;  // and rate; a hand's motion does not
  bool on_time = false;
};
// (Products of the rate are left out: a sensor swung about a point beside it is moved so.)
Dependence dependence_of(const std::vector<const Recording*>& recordings, const Stage& rotation,
                         double misfit) {
  auto dependences = general_dependences(true);
  std::erase_if(dependences, [](const auto& e) { return e->channel() != Sensor::kAcc; });
  const Scan scan(recordings, rotation, dependences);
  Dependence out;
  for (const Score& s : scan.scores()) {
    if (!(s.statistic - s.dof > kMostOfIt * misfit)) continue;
    (depends_on_time(*s.effect) ? out.on_time : out.on_attitude) = true;
  }
  return out;
}

}  // namespace

ChosenMotion choose_motion_model(const std::vector<const Recording*>& recordings,
                                 const Pipeline& pipeline, const DiagnosisOptions& options,
                                 Extender& extender, Diagnosis& d) {
  if (options.base) {
    const Stage stage = stored_model(*options.base, recordings, pipeline, d.notes);
    extender.set_base(stage);
    return {stage};
  }
  if (options.motion != MotionModel::kAuto) {
    const Stage stage = pipeline.with_fixed_symmetries(pipeline.coarse_fit(options.motion));
    extender.set_base(stage);
    return {stage};
  }
  const AccNoise noise = largest_acc_noise(recordings, pipeline.rest_noise().acc);
  std::string why;
  const auto fitted = [&](MotionModel motion) {
    return attempt([&] { return pipeline.with_fixed_symmetries(pipeline.coarse_fit(motion)); },
                   &why);
  };
  const std::optional<Stage> turning = fitted(MotionModel::kRotation);
  const std::optional<Stage> held = fitted(MotionModel::kHandHeld);
  if (!turning && !held) throw NumericalError(why);
  extender.set_base(turning ? *turning : *held);
  // Where one of the two models has no fit, the other is taken.
  if (!turning || !held) return {turning ? *turning : *held};
  const Stage &rotation = *turning, &moving = *held;
  const Restlessness restless = restlessness(rotation, noise);
  bool at_fault = false;  // the accelerometer
  std::optional<Finding> moved;
  const auto finding = [&] {
    if (!moved) moved = motion_finding(moving, restless);
    return *moved;
  };
  const auto chosen = [&](const Stage& stage) {
    if (at_fault || !is_beyond_reach(moving)) return ChosenMotion{stage};
    return ChosenMotion{stage, reach_in_words(moving), finding()};
  };
  // Coloured noise and heavy tails look like a motion, but they show in rests, too.
  if (!more_in_motion(node_residuals(rotation, recordings, Sensor::kAcc)) ||
      choose_motion(rotation, moving, noise).motion == MotionModel::kRotation) {
    return chosen(rotation);
  }
  // A bias that changes in mid-recording may be the only cause, or it may come with a motion.
  const Dependence dependence = dependence_of(recordings, rotation, restless.squares);
  at_fault = dependence.on_time;
  if (dependence.on_time || has_rivals(recordings, pipeline, extender, rotation, restless, noise)) {
    const Diagnosis before = d;
    extender.extend(rotation);
    if (is_calm(restlessness(extender.stage(), noise))) return chosen(extender.stage());
    d = before;
  }
  if (dependence.on_attitude) return chosen(rotation);
  d.findings.push_back(finding());
  return chosen(moving);
}

std::optional<Stage> find_small_motion(const std::vector<const Recording*>& recordings,
                                       const Pipeline& pipeline, Extender& extender, Diagnosis& d) {
  const Stage& stage = extender.stage();
  if (stage.spec().motion != MotionModel::kRotation) return std::nullopt;
  // A sensor that swings about a fixed point is not moved by a hand.
  for (const auto& e : stage.spec().effects) {
    if (e->description().rotation_only) return std::nullopt;
  }
  const NodeResiduals residuals = node_residuals(stage, recordings, Sensor::kAcc);
  const SlowPower acc = slow_power(residuals);
  if (acc.z() < kSlowSigmas || acc.log_ratio < kLeastSlow || acc.over_coloured() < kOverColour) {
    return std::nullopt;
  }
  // An error of another sensor bends the attitude, and that shows in the accelerometer, too, but
  // not in what it measures along the vertical. (And a motion bends the attitude, which shows in
  // the gyroscope.)
  const double vertical = slow_power(residuals, Axes::kVertical).squares;
  for (const Sensor other : {Sensor::kMag, Sensor::kGyr}) {
    const SlowPower theirs = slow_power(node_residuals(stage, recordings, other));
    if (theirs.squares > kMostOfIt * acc.squares && theirs.z() > kTheirSigmas &&
        vertical < kOfVertical * (acc.squares + theirs.squares)) {
      return std::nullopt;
    }
  }
  const Dependence dependence = dependence_of(recordings, stage, acc.squares);
  if (dependence.on_attitude || dependence.on_time) return std::nullopt;
  std::optional<Stage> fitted;  // without effects
  const auto with_effects = attempt([&] {
    fitted = pipeline.with_fixed_symmetries(pipeline.coarse_fit(MotionModel::kHandHeld));
    if (stage.spec().effects.empty()) return *fitted;
    ModelSpec spec = fitted->spec();
    spec.effects = stage.spec().effects;
    return pipeline.refit(*fitted, spec);
  });
  if (!with_effects || !with_effects->result().converged()) return std::nullopt;
  const Stage &plain = *fitted, &moving = *with_effects;
  d.findings.push_back(small_motion_finding(stage, moving, acc));
  extender.replace(moving);
  return plain;
}

bool withdraw_motion(const std::vector<const Recording*>& recordings, const Pipeline& pipeline,
                     Extender& extender, Diagnosis& d) {
  const Stage& stage = extender.stage();
  const Stage& rotation = extender.base();
  if (!is_moved(stage.spec().motion) || rotation.spec().motion != MotionModel::kRotation) {
    return false;
  }
  ModelSpec spec = rotation.spec();
  spec.effects = stage.spec().effects;
  if (spec.effects.empty()) return false;
  const auto still = attempt([&] { return pipeline.refit(rotation, spec); });
  const AccNoise noise = largest_acc_noise(recordings, pipeline.rest_noise().acc);
  if (!still || !still->result().converged() || !is_calm(restlessness(*still, noise))) {
    return false;
  }
  std::erase_if(d.findings, [](const Finding& f) { return f.effect == "linear_acceleration"; });
  extender.replace(*still);
  return true;
}

void restate_motion(const Stage& stage, Diagnosis& d) {
  if (!is_moved(stage.spec().motion)) return;
  for (Finding& f : d.findings) {
    if (f.effect == "linear_acceleration") tell_acceleration(stage, f);
  }
}

}  // namespace magimu

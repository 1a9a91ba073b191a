// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/pipeline.h"

#include <fmt/format.h>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "calibration/fit/choose_motion.h"
#include "calibration/fit/diagnostics.h"
#include "calibration/fit/held_out.h"
#include "calibration/fit/marginal_likelihood.h"
#include "calibration/fit/side_by_side.h"
#include "calibration/fit/summary.h"
#include "calibration/model/exact_symmetries.h"
#include "calibration/model/extension.h"
#include "calibration/motion/rests/rests.h"
#include "calibration/scan/change_search.h"
#include "calibration/scan/unseen_tolerances.h"
#include "calibration/travelling.h"
#include "calibration/trust/better_than_none.h"
#include "calibration/worth_of_effect.h"
#include "graph/numerical_error.h"
#include "recording/checks/repeats.h"
#include "recording/data/parts.h"
#include "solvers/marginals.h"

namespace magimu {
namespace {

constexpr double kCoarseRate = 12.0;     // nodes a second while the noise is being found
constexpr double kCoarseStep = 1e-3;     // standard deviations: that fit is no end in itself
constexpr double kFullRate = 101.0;      // up to here every magnetometer sample is a node
constexpr double kDecimatedRate = 40.0;  // above, so many nodes a second at most
// Nodes of the last fit and of those before, of all recordings together, at most: a node takes some
// 12 kB. The first is an hour at 17 nodes a second, the second an hour at kCoarseRate: with fewer,
// effects were found in it that were not there.
constexpr double kMostNodes = 60000.0, kMostCoarseNodes = 45000.0;
// Noise in motion over that at rest, at the most (and at least that at rest: the trajectory follows
// the gyroscope so closely that its residuals alone may let its noise vanish). What exceeds it is
// not noise but something the model lacks; it must show in the residuals instead of being declared
// normal.
constexpr double kGyrInMotion = 3.0, kMagInMotion = 2.5;
constexpr double kSwungAtRest = 5.0;  // times the noise at rest
constexpr double kUnlimited = 1e30;
constexpr int kMostCompared = 8;  // recordings that are calibrated one by one, too
// Samples are averaged about a node as if the gyroscope were exact there. Its noise within a block
// and that between nodes are one, though: the means of a block follow 2/3 of the variance between
// two. That counts where the magnetometers see this noise, which the share of its rows tells that
// the fit leaves free: at 0.1 the density comes out 0.99 of the truth, at 0.3 0.94, at 2/3 0.82.
// Of arrays: one magnetometer alone sees little of it, and its density is lost in the scatter.
constexpr double kGyrSeen = 0.1;
// m/s^2, rad/s per sqrt(Hz): where a search for the noise begins that no rest tells.
constexpr double kUsualAcc = 0.01, kUsualGyr = 1e-3;
constexpr double kLeastAcc = 1e-6, kLeastGyr = 1e-8;  // m/s^2, rad/s per sqrt(Hz): no part has less
// Sampling intervals. No further: what exceeds one is no matter of sampling.
constexpr double kAccJitter[] = {0.25, 0.5, 1.0};
constexpr double kWorthJitter = 3.3;  // nats; about 1 % by chance
// Nats: odds of 27 to 1. A part's error that is worth less leaves the calibration where it is, and
// its doubt is in the sigmas (scan/unseen_tolerances.h).
constexpr double kWorthPart = 3.3;
// Of what an error of a part explains: a change that promises so much in one step is tried.
constexpr double kPromised = 0.2;
constexpr double kWorse = 2.0;  // standard errors of a gain below zero
// Neighbouring velocities are not independent where their correlation exceeds so many standard
// deviations. Fewest velocities of the longest part: they tell the speed to 18 % (two axes each).
constexpr double kAlikeVelocities = 2.0, kFewestVelocities = 8.0;
constexpr double kMatrixShown = 3.0;  // standard errors of a gain that is believed
// Standard deviations of a lag that is believed; of one that may be, with noise estimated anew.
constexpr double kOffsetShown = 4.0, kOffsetPossible = 2.0;

NoiseDensities noise_of_rests(const std::vector<const Recording*>& recordings) {
  NoiseDensities noise;
  for (const Recording* r : recordings) {
    const NoiseDensities rest = noise_at_rest(*r, find_rests(*r));
    noise.acc = std::max(noise.acc, rest.acc);
    noise.gyr = std::max(noise.gyr, rest.gyr);
    noise.mag = std::max(noise.mag, rest.mag);
  }
  return noise;
}

// Where the rests do not tell: values of ordinary parts, and what the magnetometer's ellipsoid
// leaves unexplained, for the residuals to correct.
NoiseDensities completed(NoiseDensities noise, const InitialGuess& guess) {
  if (noise.acc <= 0.0) noise.acc = kUsualAcc;
  if (noise.gyr <= 0.0) noise.gyr = kUsualGyr;
  if (noise.mag <= 0.0) {
    noise.mag = std::max(guess.ellipsoid_rms_uT / std::sqrt(kCoarseRate), 1e-6);
  }
  return noise;
}

// Root mean square scatter of the specific force's length about its mean, m/s^2.
double force_spread(const std::vector<const Recording*>& recordings) {
  double n = 0.0, sum = 0.0, squares = 0.0;
  for (const Recording* r : recordings) {
    for (const Vector3& f : r->acc.v) {
      n += 1.0;
      sum += f.norm();
      squares += f.squaredNorm();
    }
  }
  return std::sqrt(std::max(0.0, squares / n - sum / n * (sum / n)));
}

// Where samples come in heaps the usual interval says nothing of their number.
double samples_a_second(const VectorSeries& s) {
  return std::min(s.rate_hz(), double(s.size()) / std::max(1e-3, s.t.back() - s.t.front()));
}

// Samples of the first magnetometer a node, with so many nodes at most.
int fewest_a_node(const std::vector<const Recording*>& recordings, double most_nodes) {
  double samples = 0.0;
  for (const Recording* r : recordings) samples += double(r->mag.front().size());
  return int(std::ceil(samples / most_nodes));
}

int automatic_node_every(const std::vector<const Recording*>& recordings) {
  const double rate = samples_a_second(recordings.front()->mag.front());
  const int usual = rate <= kFullRate ? 1 : int(std::ceil(rate / kDecimatedRate));
  return std::max(usual, fewest_a_node(recordings, kMostNodes));
}

}  // namespace

std::vector<double> largest_mag_noise(const std::vector<const Recording*>& recordings) {
  const std::size_t magnetometers = recordings.front()->mag.size();
  // Where it rests, a coarse converter says the same all the time; in motion rounding is noise.
  std::vector<double> rest(magnetometers, 0.0), rounding(magnetometers, 0.0);
  for (const Recording* r : recordings) {
    const std::vector<double> own = mag_noise_at_rest(*r, find_rests(*r));
    for (std::size_t m = 0; m < magnetometers; ++m) {
      rest[m] = std::max(rest[m], own[m]);
      const Vector3 step = least_steps(r->mag[m]);
      const double rate = r->mag[m].rate_hz();
      if (!step.allFinite() || !(rate > 0.0)) continue;
      rounding[m] = std::max(rounding[m], std::sqrt(step.squaredNorm() / (3.0 * 12.0) / rate));
    }
  }
  std::vector<double> out;
  for (std::size_t m = 0; m < magnetometers; ++m) {
    out.push_back(rest[m] > 0.0 ? kMagInMotion * std::hypot(rest[m], rounding[m]) : kUnlimited);
  }
  return out;
}

Pipeline::Pipeline(const std::vector<const Recording*>& recordings,
                   const CalibrationOptions& options, std::vector<NodePlan> coarse_plans)
    : recordings_(recordings),
      options_(options),
      coarse_optimizer_(options.optimizer),
      guess_(initialize(recordings, options.initialization)),
      rest_(options.noise.value_or(noise_of_rests(recordings))),
      most_mags_(largest_mag_noise(recordings)) {
  for (const Recording* r : recordings) {
    if (rest_.acc <= 0.0) least_.acc = std::max({kLeastAcc, least_.acc, least_noise(r->acc)});
    if (rest_.gyr <= 0.0) least_.gyr = std::max({kLeastGyr, least_.gyr, least_noise(r->gyr)});
  }
  coarse_optimizer_.step_tolerance = std::max(coarse_optimizer_.step_tolerance, kCoarseStep);
  const double mag_rate = samples_a_second(recordings.front()->mag.front());
  every_ = options.node_every > 0 ? options.node_every : automatic_node_every(recordings);
  coarse_every_ = std::max({every_, int(std::ceil(mag_rate / kCoarseRate)),
                            fewest_a_node(recordings, kMostCoarseNodes)});
  coarse_plans_ =
      coarse_plans.empty() ? plan_nodes(recordings, coarse_every_) : std::move(coarse_plans);
}

Stage Pipeline::with_fixed_symmetries(const Stage& stage) const {
  Values values = stage.result().values;
  fix_symmetries(values, int(recordings_.front()->mag.size()), stage.plans());
  if (std::ranges::equal(values.data(), stage.result().values.data())) return stage;
  Stage fixed = stage;
  fixed.fit(values, true);
  return fixed;
}

Values Pipeline::start_of(const Stage& stage, const Stage& from, const VectorXd& start) const {
  Values values = carry_over(recordings_, from, stage);
  if (start.size() > 0) {
    const std::vector<Key> last = effect_keys(stage.spec().effects).back();
    for (std::size_t i = 0; i < last.size(); ++i) values.update(last[i], start[Eigen::Index(i)]);
  }
  return values;
}

Stage Pipeline::beside(const Stage& from, const ModelSpec& spec) const {
  return from.is_of(recordings_, coarse_plans_)
             ? Stage(from, spec, coarse_optimizer_)
             : Stage(recordings_, spec, coarse_plans_, coarse_optimizer_);
}

Stage Pipeline::refit(const Stage& from, const ModelSpec& spec, const VectorXd& start) const {
  Stage stage = beside(from, spec);
  fit_with_noise(stage, start_of(stage, from, start), true);
  return stage;
}

Stage Pipeline::refit(const ModelSpec& spec, const Values& start) const {
  Stage stage(recordings_, spec, coarse_plans_, coarse_optimizer_);
  fit_with_noise(stage, start, true);
  return stage;
}

Stage Pipeline::refit_with_same_noise(const Stage& from, const ModelSpec& spec,
                                      const VectorXd& start) const {
  Stage stage = beside(from, spec);
  stage.fit(start_of(stage, from, start), true);
  return stage;
}

Stage Pipeline::fine(const Stage& coarse) const {
  Stage out(recordings_, coarse.spec(), every_, options_.optimizer);
  const Values start = carry_over(recordings_, coarse, out);
  const bool array = recordings_.front()->mag.size() > 1;
  if (array && coarse.gyr_freedom() > kGyrSeen && every_ < coarse_every_) {
    fit_with_noise(out, start, true);
    // What one sensor's noise loses another's gains, slowly: steps of 1 %, at which a fit stops,
    // are followed by some 2 % more.
    constexpr int kMoreRounds = 3;
    for (int i = 0; i < kMoreRounds; ++i) fit_with_noise(out, Values(out.result().values), true);
  } else {
    out.fit(start, true);
  }
  return with_fixed_symmetries(out);
}

std::vector<Check> Pipeline::check_prediction(const Stage& coarse) const {
  if (!coarse.result().converged()) return {};
  const Matrix3 D = coarse.result().values.at<Matrix3>(key::distortion);
  const double strength = std::cbrt(std::abs(D.determinant()));
  const double correction = correction_rad(D, coarse.result().values.at<Vector3>(key::mag_bias));
  const bool obvious = correction > kObviousCorrection;
  std::optional<BlockErrors> errors, as_they_come;
  std::optional<Check> agreement, each;
  std::string why;
  const auto ask_without = [&] {
    return block_errors(with_readings_as_they_come(recordings_, coarse));
  };
  side_by_side(
      coarse.plans(), [&] { errors = attempt([&] { return block_errors(coarse); }, &why); },
      [&] {
        if (!obvious) as_they_come = attempt(ask_without);
      },
      [&] { agreement = halves(coarse); }, [&] { each = recordings_apart(coarse); });
  std::vector<Check> out;
  if (errors) {
    out.push_back(check_held_out(*errors, strength));
  } else {
    out.push_back({"cross_validation", CheckStatus::kBad, 0.0,
                   fmt::format("The fit without some of the magnetometer's samples, which were to "
                               "be predicted, failed: {}.",
                               why)});
  }
  if (obvious) out.push_back(no_gain_to_ask_for(correction));
  if (errors && as_they_come) out.push_back(check_gain(*as_they_come, *errors, strength));
  if (agreement) out.push_back(*agreement);
  if (each) out.push_back(*each);
  return out;
}

std::optional<Check> Pipeline::halves(const Stage& coarse) const {
  if (!coarse.result().converged()) return std::nullopt;
  std::optional<Calibration> first, second;
  side_by_side(
      coarse.plans(), [&] { first = attempt([&] { return half(coarse, false); }); },
      [&] { second = attempt([&] { return half(coarse, true); }); });
  if (!first || !second || !first->fit.converged() || !second->fit.converged()) return std::nullopt;
  return check_halves(*first, *second);
}

// Of each recording one half, calibrated as all of it was. Of a recording in parts, half of the
// time that they last together.
Calibration Pipeline::half(const Stage& coarse, bool second) const {
  const std::vector<int> fields = fields_of(recordings_);
  std::vector<double> length(std::size_t(fields.back()) + 1, 0.0), before(length.size(), 0.0);
  const auto length_of = [](const Recording& r) { return r.gyr.t.back() - r.gyr.t.front(); };
  for (std::size_t i = 0; i < fields.size(); ++i) {
    length[std::size_t(fields[i])] += length_of(*recordings_[i]);
  }
  std::vector<Recording> parts;
  std::vector<std::size_t> of;  // the recording of each
  int last_field = -1;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const auto f = std::size_t(fields[i]);
    const Recording& r = *recordings_[i];
    const double begin = r.gyr.t.front(), end = r.gyr.t.back();
    const double mid = begin + std::clamp(0.5 * length[f] - before[f], 0.0, end - begin);
    before[f] += end - begin;
    Recording part = second ? slice(r, mid, end) : slice(r, begin, mid);
    if (!tells_something(part)) continue;
    part.continues_previous = fields[i] == last_field;
    last_field = fields[i];
    parts.push_back(std::move(part));
    of.push_back(i);
  }
  std::vector<const Recording*> half;
  for (const Recording& part : parts) half.push_back(&part);
  Calibration out;
  if (field_count(half) != field_count(recordings_)) return out;
  for (std::size_t m = 0; m < recordings_.front()->mag.size(); ++m) {  // one may have died
    const bool reads =
        std::ranges::any_of(parts, [&](const Recording& part) { return !part.mag[m].empty(); });
    if (!reads) return out;
  }
  Stage stage(half, coarse.spec(), coarse_every_, coarse_optimizer_);
  stage.fit(carry_over(half, coarse, stage, of), true);
  out.fit = stage.result();
  return stage.result().converged() ? summarize_parameters(half, stage, options_) : out;
}

std::optional<Check> Pipeline::recordings_apart(const Stage& coarse) const {
  const int n = field_count(recordings_);
  if (!coarse.result().converged() || n < 2 || n > kMostCompared) return std::nullopt;
  std::vector<std::optional<Calibration>> each(static_cast<std::size_t>(n));
  std::vector<std::string> names(each.size());
  const std::vector<int> fields = fields_of(recordings_);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    names[std::size_t(fields[i])] = recordings_[i]->name;
  }
  parallel::for_each(each.size(), [&](std::size_t f) {
    each[f] = attempt([&] { return of_field(coarse, int(f)); });
    if (each[f] && (!each[f]->fit.converged() || !each[f]->undetermined.empty())) each[f].reset();
  });
  return check_recordings(each, names);
}

Calibration Pipeline::of_field(const Stage& coarse, int field) const {
  const std::vector<int> fields = fields_of(recordings_);
  std::vector<const Recording*> own;
  std::vector<std::size_t> of;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (fields[i] != field) continue;
    own.push_back(recordings_[i]);
    of.push_back(i);
  }
  Calibration out;
  for (std::size_t m = 0; m < recordings_.front()->mag.size(); ++m) {
    if (std::ranges::all_of(own, [&](const Recording* r) { return r->mag[m].empty(); })) return out;
  }
  Stage stage(own, coarse.spec(), coarse_every_, coarse_optimizer_);
  // What belongs to its field is that of the first one here.
  Values start;
  const Values carried = carry_over(own, coarse, stage, of);
  for (const Values::Slot& s : carried.slots()) {
    if (s.key.symbol == dip_of(0).symbol) {
      if (s.key == dip_of(field)) start.insert(dip_of(0), carried.at<double>(s.key));
    } else if (s.key.symbol == key::lever_arm_of(0).symbol) {
      if (s.key == key::lever_arm_of(field)) {
        start.insert(key::lever_arm_of(0), carried.at<Vector3>(s.key));
      }
    } else {
      start.insert_from(carried, s.key);
    }
  }
  stage.fit(start, true);
  out.fit = stage.result();
  return stage.result().converged() ? summarize_parameters(own, stage, options_) : out;
}

ModelSpec Pipeline::first_spec(MotionModel motion) const {
  ModelSpec spec;
  spec.motion = motion;
  spec.gravity = options_.gravity;
  spec.also = options_.also;
  spec.noise = starting_noise();
  if (motion == MotionModel::kRotation && !options_.noise && rest_.acc > 0.0) {
    // A swung sensor is far from this model: a start with the noise of its rests would have to come
    // a long way.
    const double swung = force_spread(recordings_) / std::sqrt(kCoarseRate);
    if (swung > kSwungAtRest * rest_.acc) spec.noise.acc = swung;
  }
  return spec;
}

NoiseDensities Pipeline::starting_noise() const {
  return options_.noise.value_or(completed(rest_, guess_));
}

ModelStart Pipeline::model_start(MotionModel motion) const {
  ModelStart out;
  out.spec = first_spec(motion);
  out.spec.gyr_bias = guess_.parameters.gyr_bias;
  out.plans = coarse_plans_;
  out.graph = build_model(recordings_, out.plans, out.spec);
  out.values = initial_values(recordings_, out.plans, guess_, motion);
  return out;
}

Stage Pipeline::coarse_fit(MotionModel motion) const {
  const ModelSpec spec = first_spec(motion);
  Stage stage(recordings_, spec, coarse_plans_, coarse_optimizer_);
  const Values start = initial_values(recordings_, stage.plans(), guess_, motion);
  fit_with_noise(stage, start, false);
  // From a poor start the steps of one fit may not reach the optimum, and no noise is estimated.
  if (!stage.result().converged()) fit_with_noise(stage, Values(stage.result().values), true);
  if (motion == MotionModel::kTravelling) return with_independent_velocities(std::move(stage));
  return stage;
}

Stage Pipeline::with_independent_velocities(Stage stage) const {
  double longest = 0.0;
  for (const NodePlan& plan : stage.plans()) {
    longest = std::max(longest, plan.t.back() - plan.t.front());
  }
  while (velocity_correlation(stage).sigmas > kAlikeVelocities &&
         2.0 * kFewestVelocities * stage.spec().velocity_every_s < longest) {
    ModelSpec spec = stage.spec();
    spec.velocity_every_s *= 2.0;
    Stage next(stage, spec);
    fit_with_noise(next, carry_over(recordings_, stage, next), true);
    stage = std::move(next);
  }
  return stage;
}

std::optional<Stage> Pipeline::travelling_instead(const Stage& hand_held, std::string& reason,
                                                  const std::vector<std::string>& known) const {
  if (hand_held.spec().motion != MotionModel::kHandHeld || !is_beyond_reach(hand_held)) return {};
  std::optional<Stage> out =
      attempt([&] { return with_what_it_needs(coarse_fit(MotionModel::kTravelling), known); });
  if (!out || !out->result().converged() || leaves_a_misfit(*out)) return {};
  const HeldOutGain gain = held_out_gain(hand_held, *out);
  if (gain.worse()) return {};
  reason = grounds_of_travelling(hand_held, *out, gain);
  return out;
}

void Pipeline::fit_with_noise(Stage& stage, const Values& start, bool warm) const {
  const bool moving = is_moved(stage.spec().motion);
  if (options_.noise) {
    stage.fit_noise(start, warm, {.gyr_known = true, .acc_known = true, .mag_known = true});
  } else {
    // Where the motion is modelled, the accelerometer's noise is that at rest.
    const bool acc_known = moving && rest_.acc > 0.0;
    NoiseKnowledge known{.gyr_known = rest_.gyr > 0.0 && !moving,
                         .acc_known = acc_known,
                         .min_gyr = rest_.gyr,
                         .max_gyr = rest_.gyr > 0.0 ? kGyrInMotion * rest_.gyr : kUnlimited,
                         .max_mag = most_mags_.front(),
                         .least = least_};
    if (most_mags_.size() > 1) known.max_each_mag = most_mags_;
    stage.fit_noise(start, warm, known);
  }
}

Stage Pipeline::choose(std::string& reason) const {
  if (options_.motion != MotionModel::kAuto) return coarse_fit(options_.motion);
  std::optional<Stage> rotation, hand_held;
  std::string why_no_rotation, why_not_held;
  side_by_side(
      coarse_plans_,
      [&] {
        hand_held = attempt([&] { return coarse_fit(MotionModel::kHandHeld); }, &why_not_held);
      },
      [&] {
        rotation = attempt([&] { return coarse_fit(MotionModel::kRotation); }, &why_no_rotation);
      });
  if (!rotation && !hand_held) throw NumericalError(why_not_held);
  if (!rotation) {
    reason = fmt::format("The model of a sensor that only turns has no fit: {}.", why_no_rotation);
    return *hand_held;
  }
  if (!hand_held) {
    reason = fmt::format("The model of a sensor in a hand has no fit: {}.", why_not_held);
    return *rotation;
  }
  const MotionChoice choice =
      choose_motion(*rotation, *hand_held, largest_acc_noise(recordings_, rest_.acc));
  reason = choice.reason;
  return choice.motion == MotionModel::kRotation ? *rotation : *hand_held;
}

// Few nodes first: most iterations, the search for the noise and the choices are cheap there. A
// step whose trial fails leaves the stage as it was.
Stage Pipeline::coarse(std::string& motion_reason, const std::vector<std::string>& known) const {
  Stage stage = with_what_it_needs(choose(motion_reason), known);
  if (options_.motion == MotionModel::kAuto) {
    if (auto other = travelling_instead(stage, motion_reason, known)) stage = *std::move(other);
  }
  return with_fixed_symmetries(stage);
}

Stage Pipeline::with_what_it_needs(Stage stage, const std::vector<std::string>& known) const {
  // Away from an optimum nothing tells what is needed.
  if (!stage.result().converged()) return stage;
  const auto take = [&](const auto& step) {
    if (auto next = attempt([&] { return step(stage); })) stage = *std::move(next);
  };
  take([&](const Stage& from) { return with_offset(from); });
  take([&](const Stage& from) { return with_acc_jitter(from); });
  take([&](const Stage& from) { return with_gyr_matrix(from); });
  take([&](const Stage& from) { return with_errors_of_parts(from, known); });
  take([&](const Stage& from) { return with_offset(from); });
  return stage;
}

// The stage with a lag of the magnetometers, if the data show one.
Stage Pipeline::with_offset(const Stage& stage) const {
  if (!options_.mag_time_offset.value_or(true) || stage.spec().mag_time_offset) return stage;
  ModelSpec spec = stage.spec();
  spec.mag_time_offset = true;
  Stage delayed(stage, spec);
  const bool asked = options_.mag_time_offset.has_value();
  delayed.fit(carry_over(recordings_, stage, delayed), true);
  if (!asked && !may_show_offset(delayed)) return stage;
  fit_with_noise(delayed, Values(delayed.result().values), true);
  return asked || shows_offset(delayed) ? delayed : stage;
}

// The stage with jolts that the accelerometer does not sample faithfully, as far as they make the
// readings more probable. Velocity and position follow the accelerometer so closely that its
// residuals hardly tell; the marginal likelihood does. Without them, what the hand's bounded reach
// contradicts goes into bias and tilt.
Stage Pipeline::with_acc_jitter(const Stage& stage) const {
  if (!is_moved(stage.spec().motion) || options_.noise) return stage;
  Stage best = stage;
  double likelihood = log_marginal_likelihood(best);
  for (const double jitter : kAccJitter) {
    ModelSpec spec = best.spec();
    spec.acc_jitter = jitter;
    Stage next(best, spec);
    next.fit_noise(carry_over(recordings_, best, next), true,
                   {.gyr_known = true, .acc_known = true, .mag_known = true});
    if (!next.result().converged()) break;
    const double now = log_marginal_likelihood(next);
    if (!(now > likelihood + kWorthJitter)) break;
    likelihood = now;
    best = std::move(next);
  }
  // What the jolts were before, noise of the other sensors, they are no more.
  if (best.spec().acc_jitter > 0.0) fit_with_noise(best, Values(best.result().values), true);
  return best;
}

// The stage with the gyroscope's scale errors and misalignment, if that predicts left-out
// magnetometer samples better: what fits better need not.
Stage Pipeline::with_gyr_matrix(const Stage& stage) const {
  const bool possible = is_moved(stage.spec().motion);
  if (!possible || !options_.gyr_matrix.value_or(true)) return stage;
  ModelSpec spec = stage.spec();
  spec.gyr_matrix = true;
  Stage scaled(stage, spec);
  scaled.fit(carry_over(recordings_, stage, scaled), true);
  if (!options_.gyr_matrix.has_value() && !held_out_gain(stage, scaled).better(kMatrixShown)) {
    return stage;
  }
  fit_with_noise(scaled, Values(scaled.result().values), true);
  return scaled;
}

// The stage with these effects, too, with the noise as it is; nothing where there is no optimum.
std::optional<Stage> Pipeline::with_effects(const Stage& stage,
                                            const std::vector<std::string>& names) const {
  ModelSpec spec = stage.spec();
  for (const std::string& name : names) spec.effects.push_back(find_effect(name));
  Stage next(stage, spec);
  next.fit(carry_over(recordings_, stage, next), true);
  return next.result().converged() ? std::optional(std::move(next)) : std::nullopt;
}

struct Pipeline::Compared {
  Stage stage;
  std::optional<double> likelihood{};
  std::optional<BlockErrors> errors{};

  double log_likelihood() {
    if (!likelihood) likelihood = log_marginal_likelihood(stage);
    return *likelihood;
  }
  const BlockErrors& left_out() {
    if (!errors) errors = block_errors(stage);
    return *errors;
  }
};

// Are the effects that `with` has more worth it, and left-out magnetometer samples not predicted
// worse?
bool Pipeline::pays(Compared& without, Compared& with) const {
  const double gain = with.log_likelihood() - without.log_likelihood();
  const std::size_t first = without.stage.spec().effects.size();
  if (!(worth_of_effects(recordings_, with.stage, first, gain, options_) > kWorthPart)) {
    return false;
  }
  side_by_side(
      coarse_plans_, [&] { without.left_out(); }, [&] { with.left_out(); });
  const HeldOutGain held = held_out_gain(without.left_out(), with.left_out());
  return held.mean >= -kWorse * held.error && !is_a_change_instead(without, with);
}

// Are the readings more probable by a bias that is another from some time on than by these effects?
// A matrix imitates it where each attitude is taken once or twice: both explain as much there.
bool Pipeline::is_a_change_instead(Compared& without, Compared& with) const {
  if (field_count(recordings_) > 1) return false;
  const double gained = without.stage.result().cost_final - with.stage.result().cost_final;
  for (const LikelyChange& change : changes_of_bias(recordings_, without.stage)) {
    if (0.5 * change.statistic < kPromised * gained) continue;
    ModelSpec spec = without.stage.spec();
    spec.effects.push_back(change.effect());
    Compared instead{Stage(without.stage, spec)};
    instead.stage.fit(carry_over(recordings_, without.stage, instead.stage), true);
    if (!instead.stage.result().converged()) continue;
    const double paid = std::log(change.tried);  // for its time
    if (instead.log_likelihood() - paid > with.log_likelihood()) return true;
  }
  return false;
}

// With the noise, and the jolts, that belong to its effects.
Stage Pipeline::with_noise_anew(const Stage& stage) const {
  if (!(stage.spec().acc_jitter > 0.0)) {
    Stage out = stage;
    fit_with_noise(out, Values(stage.result().values), true);
    return out;
  }
  ModelSpec spec = stage.spec();
  spec.acc_jitter = 0.0;
  Stage prompt(stage, spec);
  fit_with_noise(prompt, carry_over(recordings_, stage, prompt), true);
  return with_acc_jitter(prompt);
}

// The stage with errors that parts have as a rule, each that is worth it. Without them a hand's
// motion is bent until it explains what they do to gravity, and jolts may be what they seemed.
Stage Pipeline::with_errors_of_parts(const Stage& stage,
                                     const std::vector<std::string>& known) const {
  const bool possible = is_moved(stage.spec().motion);
  if (!possible || !options_.gyr_matrix.value_or(true)) return stage;
  Compared best{stage};
  std::deque<std::string> left(std::begin(kErrorsOfParts), std::end(kErrorsOfParts));
  if (std::optional<Stage> next = known.empty() ? std::nullopt : with_effects(stage, known)) {
    best = {*std::move(next)};
    std::erase_if(left, [&](const std::string& name) {
      return std::ranges::find(known, name) != known.end();
    });
  }
  // What was refused beside another's error may be worth it without that.
  for (std::size_t refused = 0; refused < left.size();) {
    const std::string name = left.front();
    left.pop_front();
    if (std::optional<Stage> fitted = with_effects(best.stage, {name})) {
      Compared next{*std::move(fitted)};
      if (pays(best, next)) {
        best = std::move(next);
        refused = 0;
        continue;
      }
    }
    left.push_back(name);
    ++refused;
  }
  return left.size() < std::size(kErrorsOfParts) ? with_noise_anew(best.stage) : stage;
}

bool Pipeline::may_show_offset(const Stage& stage) const {
  const Values& values = stage.result().values;
  const Marginals marginals(stage.graph(), values, options_.optimizer.backend);
  for (int m = 0; m < int(recordings_.front()->mag.size()); ++m) {
    const Key key = key::mag_time_offset_of(m);
    const double sigma = std::sqrt(marginals.determined_covariance({key})(0, 0));
    if (!(std::abs(values.at<double>(key)) < kOffsetPossible * sigma)) return true;
  }
  return false;
}

bool Pipeline::shows_offset(const Stage& stage) const {
  const Calibration c = summarize_parameters(recordings_, stage, options_);
  for (const ActiveEffect::Parameter& p : c.effects.front().parameters) {
    if (std::abs(p.value) > kOffsetShown * std::max(p.sigma, p.sigma_model)) return true;
  }
  return false;
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/pipeline.h"

#include <fmt/format.h>
#include <tbb/parallel_invoke.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibration/choose_motion.h"
#include "calibration/diagnostics.h"
#include "calibration/extension.h"
#include "calibration/held_out.h"
#include "calibration/marginal_likelihood.h"
#include "calibration/rests.h"
#include "calibration/summary.h"
#include "recording/error.h"
#include "recording/quality.h"
#include "recording/repeats.h"
#include "solvers/marginals.h"

namespace magimu {
namespace {

constexpr double kMinDuration = 5.0;     // s
constexpr double kCoarseRate = 12.0;     // nodes a second while the noise is being found
constexpr double kCoarseStep = 1e-3;     // standard deviations: that fit is no end in itself
constexpr double kFullRate = 101.0;      // up to here every magnetometer sample is a node
constexpr double kDecimatedRate = 40.0;  // above, so many nodes a second at most
// Noise in motion over that at rest, at the most (and at least that at rest: the trajectory follows
// the gyroscope so closely that its residuals alone may let its noise vanish). What exceeds it is
// not noise but something the model lacks; it must show in the residuals instead of being declared
// normal.
constexpr double kGyrInMotion = 3.0, kMagInMotion = 2.5;
constexpr double kSwungAtRest = 5.0;  // times the noise at rest
constexpr double kUnlimited = 1e30;
constexpr double kLeastAcc = 1e-6, kLeastGyr = 1e-8;  // m/s^2, rad/s per sqrt(Hz): no part has less
// Sampling intervals. No further: what exceeds one is no matter of sampling.
constexpr double kAccJitter[] = {0.25, 0.5, 1.0};
constexpr double kWorthJitter = 3.3;  // nats; about 1 % by chance
constexpr double kMatrixShown = 3.0;  // standard errors of a gain that is believed
constexpr double kManyRepeats = 0.3;  // of a magnetometer's samples: it is read too fast
// Standard deviations of a lag that is believed; of one that may be, with noise estimated anew.
constexpr double kOffsetShown = 4.0, kOffsetPossible = 2.0;

void check(const std::vector<const Recording*>& recordings) {
  if (recordings.empty()) throw InputError("", 0, 0, "no recording was given", "name at least one");
  for (const Recording* r : recordings) {
    if (r->mag.empty() || r->mag.front().empty()) {
      throw InputError(r->name, 0, 0, "there are no magnetometer samples",
                       "record the columns mag_x, mag_y, mag_z as well");
    }
    if (r->acc.size() < 10 || r->gyr.size() < 10 || r->mag.front().size() < 10 ||
        r->duration_s() < kMinDuration) {
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

// Magnetometers that are read faster than they measure, or of which samples came twice: each repeat
// would count as a sample, of a wrong time. A copy without the repeats where there are many or more
// than a coarse quantization makes by chance, and what was done.
std::optional<Recording> without_repeats(const Recording& recording,
                                         std::vector<std::string>& warnings) {
  std::optional<Recording> copy;
  for (std::size_t m = 0; m < recording.mag.size(); ++m) {
    const VectorSeries& all = recording.mag[m];
    VectorSeries own = without_repeats(all);
    const double repeats = 1.0 - double(own.size()) / double(all.size());
    // A coarse converter's samples are samples; those kept would be the ones that just changed, so
    // that the sensor would seem to be ahead.
    if (repeats < kFewRepeats || own.size() < 10 || made_by_rounding(all)) continue;
    if (repeats >= kManyRepeats) {
      warnings.push_back(
          fmt::format("{}: {:.0f} % of the samples of {} repeat the one before, so its own rate is "
                      "about {:.3g} "
                      "Hz, not {:.3g}; the repeats are left out.",
                      recording.name, 100.0 * repeats, recording.mag_names[m],
                      all.rate_hz() * (1.0 - repeats), all.rate_hz()));
    } else if (repeats < kSomeRepeats && repeats_in(all).beyond_chance()) {
      warnings.push_back(fmt::format(
          "{}: {:.2g} % of the samples of {} are the one before once more, lost on their way or "
          "read twice; they are left out.",
          recording.name, 100.0 * repeats, recording.mag_names[m]));
    } else {
      continue;
    }
    if (!copy) copy = recording;
    copy->mag[m] = std::move(own);
  }
  return copy;
}

// The two exact symmetries of the contract: cos(alpha) > 0, and det D > 0 of magnetometer 0.
void fix_symmetries(Values& values, int magnetometers, int recordings,
                    const std::vector<NodePlan>& plans) {
  const Rot3 half_turn = Rot3::from_unit_quaternion(Vector4(0.0, 0.0, 0.0, 1.0));
  const auto turn = [&](const NodePlan& plan) {
    for (int k = 0; k < int(plan.t.size()); ++k) {
      const int id = plan.first + k;
      values.update(R(id), half_turn * values.at<Rot3>(R(id)));
      if (!values.contains(V(id))) continue;
      values.update(V(id), Vector3(half_turn * values.at<Vector3>(V(id))));
      values.update(P(id), Vector3(half_turn * values.at<Vector3>(P(id))));
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

// Where it rests, a coarse converter says the same all the time; in motion rounding is noise. Its
// density, uT.
double rounding_noise(const std::vector<const Recording*>& recordings) {
  double most = 0.0;
  for (const Recording* r : recordings) {
    const VectorSeries& mag = r->mag.front();
    const Vector3 step = least_steps(mag);
    if (!step.allFinite() || !(mag.rate_hz() > 0.0)) continue;
    most = std::max(most, std::sqrt(step.squaredNorm() / (3.0 * 12.0) / mag.rate_hz()));
  }
  return most;
}

// Where the rests do not tell: values of ordinary parts, and what the magnetometer's ellipsoid
// leaves unexplained, for the residuals to correct.
NoiseDensities completed(NoiseDensities noise, const InitialGuess& guess) {
  if (noise.acc <= 0.0) noise.acc = 0.01;
  if (noise.gyr <= 0.0) noise.gyr = 1e-3;
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

int automatic_node_every(const Recording& recording) {
  const double rate = recording.mag.front().rate_hz();
  return rate <= kFullRate ? 1 : int(std::ceil(rate / kDecimatedRate));
}

}  // namespace

CheckedRecordings::CheckedRecordings(const std::vector<const Recording*>& given)
    : copies_(given.size()), recordings_(given) {
  check(given);
  for (std::size_t r = 0; r < given.size(); ++r) {
    const std::vector<Issue> issues = check_recording(*given[r]);
    refuse_fatal(*given[r], issues);
    for (const Issue& issue : issues) {
      if (issue.severity == Severity::kCaution)
        warnings_.push_back(given[r]->name + ": " + issue.text());
    }
    copies_[r] = without_repeats(*given[r], warnings_);
    if (copies_[r]) recordings_[r] = &*copies_[r];
  }
}

Pipeline::Pipeline(const std::vector<const Recording*>& recordings,
                   const CalibrationOptions& options)
    : recordings_(recordings),
      options_(options),
      coarse_optimizer_(options.optimizer),
      guess_(initialize(recordings, options.initialization)),
      rest_(options.noise.value_or(noise_of_rests(recordings))),
      rounding_(rounding_noise(recordings)) {
  for (const Recording* r : recordings) {
    if (rest_.acc <= 0.0) least_.acc = std::max({kLeastAcc, least_.acc, least_noise(r->acc)});
    if (rest_.gyr <= 0.0) least_.gyr = std::max({kLeastGyr, least_.gyr, least_noise(r->gyr)});
  }
  coarse_optimizer_.step_tolerance = std::max(coarse_optimizer_.step_tolerance, kCoarseStep);
  const double mag_rate = recordings.front()->mag.front().rate_hz();
  every_ = options.node_every > 0 ? options.node_every : automatic_node_every(*recordings.front());
  coarse_every_ = std::max(every_, int(std::ceil(mag_rate / kCoarseRate)));
}

Stage Pipeline::with_fixed_symmetries(const Stage& stage) const {
  Values values = stage.result().values;
  fix_symmetries(values, int(recordings_.front()->mag.size()), int(recordings_.size()),
                 stage.plans());
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

Stage Pipeline::refit(const Stage& from, const ModelSpec& spec, const VectorXd& start) const {
  Stage stage(recordings_, spec, coarse_every_, coarse_optimizer_);
  fit_with_noise(stage, start_of(stage, from, start), true);
  return stage;
}

Stage Pipeline::refit_with_same_noise(const Stage& from, const ModelSpec& spec,
                                      const VectorXd& start) const {
  Stage stage(recordings_, spec, coarse_every_, coarse_optimizer_);
  stage.fit(start_of(stage, from, start), true);
  return stage;
}

// Few nodes first: most iterations, the search for the noise and the choices are cheap there.
Stage Pipeline::coarse(std::string& motion_reason) const {
  return with_fixed_symmetries(
      with_gyr_matrix(with_acc_jitter(with_offset(choose(motion_reason)))));
}

Stage Pipeline::fine(const Stage& coarse) const {
  Stage out(recordings_, coarse.spec(), every_, options_.optimizer);
  out.fit(carry_over(recordings_, coarse, out), true);
  return out;
}

std::vector<Check> Pipeline::check_prediction(const Stage& coarse) const {
  if (!coarse.result().converged()) return {};
  const Matrix3 D = coarse.result().values.at<Matrix3>(key::distortion);
  BlockErrors errors;
  Calibration first, second;
  tbb::parallel_invoke([&] { errors = block_errors(coarse); }, [&] { first = half(coarse, false); },
                       [&] { second = half(coarse, true); });
  std::vector<Check> out = {check_held_out(errors, std::cbrt(std::abs(D.determinant())))};
  if (first.fit.converged() && second.fit.converged()) out.push_back(check_halves(first, second));
  return out;
}

std::optional<Check> Pipeline::halves(const Stage& coarse) const {
  if (!coarse.result().converged()) return std::nullopt;
  Calibration first, second;
  tbb::parallel_invoke([&] { first = half(coarse, false); }, [&] { second = half(coarse, true); });
  if (!first.fit.converged() || !second.fit.converged()) return std::nullopt;
  return check_halves(first, second);
}

// Of each recording one half, calibrated as all of it was.
Calibration Pipeline::half(const Stage& coarse, bool second) const {
  std::vector<Recording> parts;
  for (const Recording* r : recordings_) {
    const double begin = r->gyr.t.front(), end = r->gyr.t.back(), mid = 0.5 * (begin + end);
    parts.push_back(second ? slice(*r, mid, end) : slice(*r, begin, mid));
  }
  std::vector<const Recording*> half;
  for (const Recording& part : parts) half.push_back(&part);
  Stage stage(half, coarse.spec(), coarse_every_, coarse_optimizer_);
  stage.fit(carry_over(half, coarse, stage), true);
  Calibration out;
  out.fit = stage.result();
  return stage.result().converged() ? summarize_parameters(half, stage, options_) : out;
}

ModelSpec Pipeline::first_spec(MotionModel motion) const {
  ModelSpec spec;
  spec.motion = motion;
  spec.gravity = options_.gravity;
  spec.also = options_.also;
  spec.noise = options_.noise.value_or(completed(rest_, guess_));
  if (motion == MotionModel::kRotation && !options_.noise && rest_.acc > 0.0) {
    // A swung sensor is far from this model: a start with the noise of its rests would have to come
    // a long way.
    const double swung = force_spread(recordings_) / std::sqrt(kCoarseRate);
    if (swung > kSwungAtRest * rest_.acc) spec.noise.acc = swung;
  }
  return spec;
}

ModelStart Pipeline::model_start(MotionModel motion) const {
  ModelStart out;
  out.spec = first_spec(motion);
  out.spec.gyr_bias = guess_.parameters.gyr_bias;
  out.plans = plan_nodes(recordings_, coarse_every_);
  out.graph = build_model(recordings_, out.plans, out.spec);
  out.values = initial_values(recordings_, out.plans, guess_, motion);
  return out;
}

Stage Pipeline::coarse_fit(MotionModel motion) const {
  const ModelSpec spec = first_spec(motion);
  Stage stage(recordings_, spec, coarse_every_, coarse_optimizer_);
  const Values start = initial_values(recordings_, stage.plans(), guess_, motion);
  fit_with_noise(stage, start, false);
  return stage;
}

void Pipeline::fit_with_noise(Stage& stage, const Values& start, bool warm) const {
  const bool moving = stage.spec().motion == MotionModel::kHandHeld;
  if (options_.noise) {
    stage.fit_noise(start, warm, {.gyr_known = true, .acc_known = true, .mag_known = true});
  } else {
    // Where the motion is modelled, the accelerometer's noise is that at rest.
    const bool acc_known = moving && rest_.acc > 0.0;
    stage.fit_noise(start, warm,
                    {.gyr_known = rest_.gyr > 0.0 && !moving,
                     .acc_known = acc_known,
                     .min_gyr = rest_.gyr,
                     .max_gyr = rest_.gyr > 0.0 ? kGyrInMotion * rest_.gyr : kUnlimited,
                     .max_mag = rest_.mag > 0.0 ? kMagInMotion * std::hypot(rest_.mag, rounding_)
                                                : kUnlimited,
                     .least = least_});
  }
}

Stage Pipeline::choose(std::string& reason) const {
  if (options_.motion != MotionModel::kAuto) return coarse_fit(options_.motion);
  std::optional<Stage> rotation, hand_held;
  tbb::parallel_invoke([&] { hand_held = coarse_fit(MotionModel::kHandHeld); },
                       [&] { rotation = coarse_fit(MotionModel::kRotation); });
  const MotionChoice choice = choose_motion(*rotation, *hand_held, rest_.acc);
  reason = choice.reason;
  return choice.motion == MotionModel::kRotation ? *rotation : *hand_held;
}

// The stage with a lag of the magnetometers, if the data show one.
Stage Pipeline::with_offset(const Stage& stage) const {
  if (!options_.mag_time_offset.value_or(true)) return stage;
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
  if (stage.spec().motion != MotionModel::kHandHeld || options_.noise) return stage;
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
  const bool possible = stage.spec().motion == MotionModel::kHandHeld;
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

// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/calibrate.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <optional>

#include "calibration/blows.h"
#include "calibration/choose_motion.h"
#include "calibration/diagnostics.h"
#include "calibration/held_out.h"
#include "calibration/parameter_names.h"
#include "calibration/rests.h"
#include "calibration/stage.h"
#include "calibration/trust.h"
#include "calibration/uncertainty.h"
#include "recording/error.h"

namespace magimu {
namespace {

constexpr double kMinDuration = 5.0;     // s
constexpr double kCoarseRate = 12.0;     // nodes a second while the noise is being found
constexpr double kFullRate = 101.0;      // up to here every magnetometer sample is a node
constexpr double kDecimatedRate = 40.0;  // above, so many nodes a second at most
// Noise in motion over that at rest, at the most (and at least that at rest: the trajectory follows
// the gyroscope so closely that its residuals alone may let its noise vanish). What exceeds it is
// not noise but something the model lacks; it must show in the residuals instead of being declared
// normal.
constexpr double kGyrInMotion = 3.0, kMagInMotion = 2.5;
constexpr double kUnlimited = 1e30;
constexpr double kMatrixShown = 3.0;  // standard errors of a gain that is believed
constexpr double kManyRepeats = 0.3;
constexpr double kOffsetShown = 4.0;  // standard deviations of a lag that is believed

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

// Magnetometers that are read faster than they measure: each repeat would count as a sample. A copy
// without the repeats where there are many (a few are chance, of a coarse quantization), and what
// was done.
std::optional<Recording> without_repeats(const Recording& recording,
                                         std::vector<std::string>& warnings) {
  std::optional<Recording> copy;
  for (std::size_t m = 0; m < recording.mag.size(); ++m) {
    const VectorSeries& all = recording.mag[m];
    VectorSeries own = without_repeats(all);
    const double repeats = 1.0 - double(own.size()) / double(all.size());
    if (repeats < kManyRepeats || own.size() < 10) continue;
    warnings.push_back(fmt::format(
        "{}: {:.0f} % of the samples of {} repeat the one before, so its own rate is about {:.3g} "
        "Hz, not {:.3g}; the repeats are left out.",
        recording.name, 100.0 * repeats, recording.mag_names[m], all.rate_hz() * (1.0 - repeats),
        all.rate_hz()));
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

int automatic_node_every(const Recording& recording) {
  const double rate = recording.mag.front().rate_hz();
  return rate <= kFullRate ? 1 : int(std::ceil(rate / kDecimatedRate));
}

void fill_parameters(Calibration& c, const std::vector<const Recording*>& recordings,
                     const Stage& stage) {
  const Values& values = c.fit.values;
  const bool moving = c.motion == MotionModel::kHandHeld;
  c.parameters.acc_bias = values.at<Vector3>(key::acc_bias);
  c.parameters.gyr_bias = values.at<Vector3>(key::gyr_bias);
  c.parameters.dip_rad = values.at<double>(dip_of(0));
  c.parameters.mag.clear();
  c.mag_names = recordings.front()->mag_names;
  for (int m = 0; m < int(recordings.front()->mag.size()); ++m) {
    c.parameters.mag.push_back(
        {values.at<Matrix3>(key::distortion_of(m)), values.at<Vector3>(key::mag_bias_of(m))});
    if (!stage.spec().mag_time_offset) continue;
    if (m == 0) c.effects.push_back({"mag_time_offset", {}});
    c.effects.back().parameters.push_back(
        {time_offset_name(m), "s", values.at<double>(key::mag_time_offset_of(m))});
  }
  if (stage.spec().gyr_matrix) {
    const auto S = values.at<LowerTriangle>(key::gyr_matrix);
    ActiveEffect effect{"gyro_scale_misalignment", {}};
    for (int e = 0; e < 6; ++e) {
      effect.parameters.push_back({gyr_matrix_name(e), "1", S[e]});
    }
    c.effects.push_back(effect);
  }
  c.strength_uT = std::cbrt(c.parameters.mag.front().distortion.determinant());
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const NodePlan& plan = stage.plans()[r];
    TrajectoryEstimate trajectory;
    trajectory.recording = recordings[r]->name;
    trajectory.t = plan.t;
    for (int k = 0; k < int(plan.t.size()); ++k) {
      trajectory.nRb.push_back(values.at<Rot3>(R(plan.first + k)));
      if (!moving) continue;
      trajectory.v.push_back(values.at<Vector3>(V(plan.first + k)));
      trajectory.p.push_back(values.at<Vector3>(P(plan.first + k)));
    }
    c.trajectories.push_back(std::move(trajectory));
    c.samples += int(recordings[r]->gyr.size());
    c.nodes += int(plan.t.size());
    FieldEstimate field;
    field.recording = recordings[r]->name;
    field.dip_rad = values.at<double>(dip_of(int(r)));
    c.fields.push_back(field);
  }
}

void fill_residuals(Calibration& c, const Stage& stage) {
  const SensorSums sums = stage.sums();
  const std::vector<double>& t = c.trajectories.front().t;
  const double nodes_per_s = double(t.size()) / std::max(1e-9, t.back() - t.front());
  const double densities[3] = {c.noise.acc, c.noise.gyr, c.noise.mag};
  for (std::size_t s = 0; s < 3; ++s) {
    c.residuals[s].rms = sums.rms(Sensor(s));
    c.residuals[s].lag1 = sums.lag1[s];
    c.residuals[s].rms_unit = c.residuals[s].rms * densities[s] * std::sqrt(nodes_per_s);
  }
}

// Halves of a recording that disagree beyond their uncertainty show an error that persists longer
// than the blocks from which the uncertainty comes: it grows to what the halves show.
void widen_by_halves(Calibration& c) {
  for (Check& check : c.checks) {
    if (check.name != "halves" || check.status == CheckStatus::kOk) continue;
    widen_uncertainty(c, check.value);
    check.sentence += fmt::format(" All sigmas were multiplied by {:.1f}.", check.value);
  }
}

// The stages of one calibration, from the first guess to the model that is kept.
class Pipeline {
 public:
  Pipeline(const std::vector<const Recording*>& recordings, const CalibrationOptions& options)
      : recordings_(recordings),
        options_(options),
        guess_(initialize(recordings, options.initialization)),
        rest_(options.noise.value_or(rest_noise(recordings))) {
    const double mag_rate = recordings.front()->mag.front().rate_hz();
    every_ =
        options.node_every > 0 ? options.node_every : automatic_node_every(*recordings.front());
    coarse_every_ = std::max(every_, int(std::ceil(mag_rate / kCoarseRate)));
  }

  // Magnetometer samples a node of the last stage.
  int node_every() const { return every_; }

  // Few nodes first: most iterations, the search for the noise and the choices are cheap there.
  Stage run(Calibration& c) {
    const Stage coarse = with_gyr_matrix(with_offset(choose(c)));
    check_prediction(coarse, c);
    Stage fine(recordings_, coarse.spec(), every_, options_.optimizer);
    Values start = carry_over(recordings_, coarse, fine);
    fix_symmetries(start, int(recordings_.front()->mag.size()), int(recordings_.size()),
                   fine.plans());
    fine.fit(start, true);
    return fine;
  }

 private:
  // What needs more fits than one: left-out data, and halves of each recording.
  void check_prediction(const Stage& coarse, Calibration& c) const {
    if (!coarse.result().converged()) return;
    const Matrix3 D = coarse.result().values.at<Matrix3>(key::distortion);
    c.checks.push_back(check_held_out(block_errors(coarse), std::cbrt(std::abs(D.determinant()))));
    std::vector<Calibration> halves;
    for (const bool second : {false, true}) {
      std::vector<Recording> parts;
      for (const Recording* r : recordings_) {
        const double begin = r->gyr.t.front(), end = r->gyr.t.back(), mid = 0.5 * (begin + end);
        parts.push_back(second ? slice(*r, mid, end) : slice(*r, begin, mid));
      }
      std::vector<const Recording*> half;
      for (const Recording& part : parts) half.push_back(&part);
      Stage stage(half, coarse.spec(), coarse_every_, options_.optimizer);
      stage.fit(carry_over(half, coarse, stage), true);
      if (!stage.result().converged()) return;
      halves.push_back(summary(half, stage));
    }
    c.checks.push_back(check_halves(halves[0], halves[1]));
  }

  Stage coarse_fit(MotionModel motion) const {
    ModelSpec spec;
    spec.motion = motion;
    spec.gravity = options_.gravity;
    spec.noise = options_.noise.value_or(completed(rest_, guess_));
    Stage stage(recordings_, spec, coarse_every_, options_.optimizer);
    const Values start = initial_values(recordings_, stage.plans(), guess_, motion);
    fit_with_noise(stage, start);
    return stage;
  }

  void fit_with_noise(Stage& stage, const Values& start) const {
    const bool moving = stage.spec().motion == MotionModel::kHandHeld;
    if (options_.noise) {
      stage.fit_noise(start, {.gyr_known = true, .acc_known = true, .mag_known = true});
    } else {
      // Where the motion is modelled, the accelerometer's noise is that at rest.
      const bool acc_known = moving && rest_.acc > 0.0;
      stage.fit_noise(start, {.gyr_known = rest_.gyr > 0.0 && !moving,
                              .acc_known = acc_known,
                              .min_gyr = rest_.gyr,
                              .max_gyr = rest_.gyr > 0.0 ? kGyrInMotion * rest_.gyr : kUnlimited,
                              .max_mag = rest_.mag > 0.0 ? kMagInMotion * rest_.mag : kUnlimited});
    }
  }

  Stage choose(Calibration& c) const {
    if (options_.motion != MotionModel::kAuto) return coarse_fit(options_.motion);
    const Stage rotation = coarse_fit(MotionModel::kRotation);
    const Stage hand_held = coarse_fit(MotionModel::kHandHeld);
    const MotionChoice choice = choose_motion(rotation, hand_held, rest_.acc);
    c.motion_reason = choice.reason;
    return choice.motion == MotionModel::kRotation ? rotation : hand_held;
  }

  // The stage with a lag of the magnetometers, if the data show one.
  Stage with_offset(const Stage& stage) const {
    if (!options_.mag_time_offset.value_or(true)) return stage;
    ModelSpec spec = stage.spec();
    spec.mag_time_offset = true;
    Stage delayed(recordings_, spec, coarse_every_, options_.optimizer);
    fit_with_noise(delayed, carry_over(recordings_, stage, delayed));
    return options_.mag_time_offset.has_value() || shows_offset(delayed) ? delayed : stage;
  }

  // The stage with the gyroscope's scale errors and misalignment, if that predicts left-out
  // magnetometer samples better: what fits better need not.
  Stage with_gyr_matrix(const Stage& stage) const {
    const bool possible = stage.spec().motion == MotionModel::kHandHeld;
    if (!possible || !options_.gyr_matrix.value_or(true)) return stage;
    ModelSpec spec = stage.spec();
    spec.gyr_matrix = true;
    Stage scaled(recordings_, spec, coarse_every_, options_.optimizer);
    scaled.fit(carry_over(recordings_, stage, scaled), true);
    if (!options_.gyr_matrix.has_value() && !held_out_gain(stage, scaled).better(kMatrixShown)) {
      return stage;
    }
    fit_with_noise(scaled, Values(scaled.result().values));
    return scaled;
  }

  // Parameters with their uncertainty, of a stage on the way.
  Calibration summary(const std::vector<const Recording*>& recordings, const Stage& stage) const {
    Calibration c;
    c.motion = stage.spec().motion;
    c.fit = stage.result();
    fill_parameters(c, recordings, stage);
    fill_uncertainty(c, stage, options_);
    return c;
  }

  bool shows_offset(const Stage& stage) const {
    const Calibration c = summary(recordings_, stage);
    for (const ActiveEffect::Parameter& p : c.effects.front().parameters) {
      if (std::abs(p.value) > kOffsetShown * std::max(p.sigma, p.sigma_model)) return true;
    }
    return false;
  }

  const std::vector<const Recording*>& recordings_;
  const CalibrationOptions& options_;
  InitialGuess guess_;
  NoiseDensities rest_;  // given, or from rests (0 where there are none)
  int every_ = 1, coarse_every_ = 1;
};

}  // namespace

Calibration calibrate(const Recording& recording, const CalibrationOptions& options) {
  return calibrate(std::vector<const Recording*>{&recording}, options);
}

Calibration calibrate(const std::vector<const Recording*>& given,
                      const CalibrationOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  check(given);
  Calibration c;
  std::vector<const Recording*> recordings = given;
  std::vector<std::optional<Recording>> copies(given.size());
  for (std::size_t r = 0; r < given.size(); ++r) {
    copies[r] = without_repeats(*given[r], c.warnings);
    if (copies[r]) recordings[r] = &*copies[r];
  }
  Pipeline pipeline(recordings, options);
  const Stage fine = pipeline.run(c);
  c.fit = fine.result();
  c.motion = fine.spec().motion;
  if (c.motion == MotionModel::kHandHeld) c.reach_m = fine.spec().reach_m;
  c.noise = fine.spec().noise;
  c.noise_given = options.noise.has_value();
  c.gravity = options.gravity;
  c.node_every = pipeline.node_every();
  fill_parameters(c, recordings, fine);
  fill_residuals(c, fine);
  fill_uncertainty(c, fine, options);
  widen_by_halves(c);
  for (const Recording* r : recordings) {
    c.blows_per_minute = std::max(c.blows_per_minute, blows_per_minute(*r));
  }
  const std::vector<double> mag_squares = fine.mag_squares();
  c.disturbances = find_disturbances(c, mag_squares);
  const Check first[] = {check_optimum(c.fit), check_accuracy(c), check_whiteness(c),
                         check_windows(c, mag_squares)};
  c.checks.insert(c.checks.begin(), std::begin(first), std::end(first));
  judge(c);
  c.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return c;
}

}  // namespace magimu

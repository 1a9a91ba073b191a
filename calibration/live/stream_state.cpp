// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/stream_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/fit/diagnostics.h"
#include "calibration/fit/held_out.h"
#include "calibration/fit/summary.h"
#include "calibration/motion/blows.h"
#include "calibration/scan/missing_effects.h"
#include "calibration/trust/check_axes.h"
#include "calibration/trust/no_fit.h"
#include "calibration/trust/trust.h"
#include "graph/decompositions.h"
#include "graph/numerical_error.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

constexpr double kFirstWord = 0.2;       // s of stream time until the first sentence
constexpr double kFirstTry = 5.0;        // s
constexpr double kTryAgainAfter = 1.05;  // the next try, at this factor of the stream's length
constexpr double kTurned =
    2.5;  // uT: scatter of the magnetometer in every direction, for a first try
constexpr long kForFirstFit = 10;        // samples of each sensor; any fit needs more
constexpr double kStillRate = 0.2;       // rad/s: a sensor that lies still reads less (its bias)
constexpr double kStillEnough = 2.5;     // s
constexpr double kLongGap = 0.1;         // s
constexpr double kLately = 0.3;          // s
constexpr double kFeasible = 1e3;        // m/s^2, rad/s: readings beyond are no motion of a hand
constexpr int kMostIdle = 8;             // updates at the end
constexpr double kSettled = 0.003;       // sigmas
constexpr int kRefits[] = {16, 32, 64};  // numbers of windows at which all windows are fitted again

void put(const Guidance& guidance, StreamUpdate& u) {
  u.guidance = guidance.text();
  u.headline = guidance.motion.headline;
  u.axis = guidance.motion.number;
  u.missing = guidance.missing;
}

}  // namespace

StreamingCalibration::State::State(int magnetometers, const StreamingOptions& options)
    : options_(options), samples_(magnetometers, options.window_s, options.kept_s) {
  batch_.noise = options.noise;
  batch_.gravity = options.gravity;
  batch_.initialization.dip_rad = options.dip_rad;
  batch_.dip_sign = options.dip_sign;
  batch_.also = options.also;
  batch_.prior = options.prior;
  batch_.given_prior = options.given_prior;
  // The hand-held model costs next to nothing where the hand does not move. The stream itself does
  // not model travel: calibrate() decides about it at the end, if the stream is short enough.
  batch_.motion =
      options.motion == MotionModel::kRotation ? options.motion : MotionModel::kHandHeld;
  const StreamTarget& t = options.target;
  if (!t.heading_deg && !t.mag_bias_uT && !t.acc_bias && !t.gyr_bias) {
    options_.target.heading_deg = 0.5;
  }
}

std::optional<StreamUpdate> StreamingCalibration::State::add(const StreamSample& sample) {
  samples_.add(sample);
  if (estimator_) {
    if (!take_windows()) return std::nullopt;
    return estimator_ ? update() : collecting_update();
  }
  if (samples_.count() == 1) {
    still_since_ = last_gyr_t_ = sample.t;
    next_update_ = sample.t + std::min(kFirstWord, options_.window_s);
    next_try_ = kFirstTry;
  }
  look_at_turning(sample);
  look_at_field();
  if (sample.t < next_update_) return std::nullopt;
  next_update_ += options_.window_s * std::floor((sample.t - next_update_) / options_.window_s + 1);
  if (time_to_try()) try_to_start();
  return estimator_ ? update() : collecting_update();
}

int StreamingCalibration::State::last_refit() { return std::end(kRefits)[-1]; }

// Takes new windows; false if there are none.
bool StreamingCalibration::State::take_windows() {
  bool any = false;
  while (estimator_ && windows_done() < int(samples_.windows().size())) {
    const int window = windows_done();
    any = true;
    if (!add_window(samples_.windows()[std::size_t(window)])) {
      begin_anew();
      return true;
    }
    for (const int n : kRefits) {
      if (windows_done() == n) fit_all_windows();
    }
  }
  return any;
}

// The next fit of all windows then finds a start of its own.
void StreamingCalibration::State::begin_anew() {
  estimator_.reset();
  maker_.reset();
  spec_ = {};
  flagged_.clear();
  changes_.clear();
  warnings_.clear();
  judge_next_ = 0;
  flagged_in_a_row_ = 0;
  consistency_ = {};
  window_fit_ = {};
  on_the_way_.forget();
  forget_changes();
  next_update_ = samples_.last_t();
  next_try_ = kTryAgainAfter * (samples_.last_t() - samples_.first_t());
}

// As the samples come, for they pass the gate later.
void StreamingCalibration::State::look_at_turning(const StreamSample& sample) {
  if (sample.acc && sample.acc->norm() < kFeasible) felt_.emplace_back(sample.t, *sample.acc);
  while (!felt_.empty() && felt_.front().first < sample.t - kLately) felt_.pop_front();
  if (!sample.gyr || !(sample.gyr->norm() < kFeasible)) return;
  const double dt = std::min(sample.t - last_gyr_t_, kLongGap);
  last_gyr_t_ = sample.t;
  if (sample.gyr->norm() > kStillRate) {
    still_since_ = sample.t;
    if (dt > 0.0) turned_ += sample.gyr->cwiseAbs() * dt;
  }
  longest_still_ = std::max(longest_still_, sample.t - still_since_);
}

void StreamingCalibration::State::look_at_field() {
  const VectorSeries& mag = samples_.all().mag.front();
  for (; mags_ < mag.size(); ++mags_) {
    if (mags_ == 0) mag_origin_ = mag.v.front();
    const Vector3 m = mag.v[mags_] - mag_origin_;
    mag_sum_ += m;
    mag_squares_ += m * m.transpose();
  }
}

bool StreamingCalibration::State::time_to_try() const {
  if (samples_.last_t() - samples_.first_t() < next_try_ || mags_ < kForFirstFit) return false;
  const Vector3 mean = mag_sum_ / double(mags_);
  const Matrix3 scatter = mag_squares_ / double(mags_) - mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(MatrixXd(scatter), Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[0] > kTurned * kTurned && samples_.all().acc.size() > kForFirstFit &&
         samples_.all().gyr.size() > kForFirstFit;
}

std::optional<Calibration> StreamingCalibration::State::estimate() const {
  if (!estimator_) return std::nullopt;
  return stream_estimate(*estimator_, spec_, last_fit_, last_fit_s_, consistency_.overdispersion());
}

// The largest standard deviation of the target over the wanted one.
double StreamingCalibration::State::distance(const Calibration& c) const {
  const StreamTarget& t = options_.target;
  const auto largest = [&](Eigen::Index first) {
    return std::sqrt(c.covariance.diagonal().segment(first, 3).maxCoeff());
  };
  double out = 0.0;
  if (t.heading_deg) out = heading_sigma_deg(c) / *t.heading_deg;
  if (t.acc_bias) out = std::max(out, largest(0) / *t.acc_bias);
  if (t.gyr_bias) out = std::max(out, largest(3) / *t.gyr_bias);
  for (std::size_t m = 0; t.mag_bias_uT && m < c.parameters.mag.size(); ++m) {
    out = std::max(out, largest(15 + 12 * Eigen::Index(m)) / *t.mag_bias_uT);
  }
  return out;
}

// The upward direction in the sensor's frame, from the last readings of the accelerometer; zero if
// there are none.
Vector3 StreamingCalibration::State::upward() const {
  Vector3 sum = Vector3::Zero();
  for (const auto& [t, acc] : felt_) sum += acc;
  return sum.normalized();
}

StreamUpdate StreamingCalibration::State::collecting_update() {
  StreamUpdate u;
  u.t = samples_.last_t();
  u.samples = samples_.count();
  // Of a sensor that only turns the residuals tell the noise; velocity and position follow the
  // accelerometer too closely.
  const bool rested =
      batch_.noise || batch_.motion == MotionModel::kRotation || longest_still_ > kStillEnough;
  const Guidance guidance = guide(turned_, upward(), rested);
  put(guidance, u);
  // Directions in numbers tell whoever holds the sensor nothing.
  if (!undetermined_.empty()) u.guidance += " Not all is determined yet.";
  tell_news();
  std::swap(u.events, events_);
  return u;
}

StreamUpdate StreamingCalibration::State::update() {
  StreamUpdate u;
  u.t = samples_.last_t();
  u.samples = samples_.count();
  u.phase = StreamPhase::kCalibrating;
  u.window = window_fit_;
  u.flagged_windows = flagged_;
  tell_news();
  tell_change();
  u.sensor_change = changed_;
  std::swap(u.events, events_);
  Calibration c;
  try {
    c = *estimate();
  } catch (const std::domain_error& undetermined) {
    u.guidance = fmt::format("Turn it about all three of its axes: {}.", undetermined.what());
    u.headline = "Turn it";
    return u;
  }
  c.trust = {};
  add_set_aside(c);
  judge(c);
  const double to_go = distance(c);
  on_the_way_.add(u.t, c, to_go, window_fit_);
  u.checks = on_the_way_.checks();
  u.checks.insert(u.checks.begin(), {check_accuracy(c), check_whiteness(c)});
  if (changed_) {
    u.checks.push_back({"sensor_change", CheckStatus::kCaution, changed_->log_odds,
                        sentence(*changed_, samples_.all().mag_names)});
  }
  if (to_go > 1.0) borne_out_ = false;
  if (to_go <= 1.0 && c.trust.verdict != Verdict::kNo && is_good_enough()) {
    u.phase = StreamPhase::kConverged;
    u.guidance = "Good enough; what follows makes it better still.";
    u.headline = "Good enough";
  } else {
    const Guidance guidance = guide(*estimator_, spec_, R(samples_.windows().back().last), c,
                                    [this](const Calibration& with) { return distance(with); });
    put(guidance, u);
    if (to_go <= 1.0 && !not_yet_.empty()) u.guidance += " Not good enough yet: " + not_yet_;
  }
  u.theta = std::move(c);
  return u;
}

void StreamingCalibration::State::settle() {
  for (int i = 0; estimator_ && i < kMostIdle; ++i) {
    const UpdateResult result = estimator_->idle();
    if (result.largest_drift < 1.0 && result.step_sigma < kSettled) break;
  }
}

}  // namespace magimu

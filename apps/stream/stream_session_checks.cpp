// SPDX-License-Identifier: BSD-3-Clause
// What a session says of the samples themselves while they arrive
// (calibration/live/checks/live_checks.h), and what that means for its estimate.
#include <algorithm>

#include "apps/stream/stream_judge.h"
#include "apps/stream/stream_session.h"
#include "recording/data/axes.h"

namespace magimu::apps {
namespace {

// A turn by hand, about one axis: for so long, so fast, so much of it about that axis.
constexpr double kMoment_s = 0.3, kTurningRate = 0.35, kMostlyOneAxis = 0.85;

}  // namespace

// As soon as the header tells which sensors there are.
void StreamSession::begin_checks() {
  Recording sensors;  // without samples
  sensors.name = options_.address.text;
  sensors.mag_names = lines_.mag_names();
  sensors.mag.resize(sensors.mag_names.size());
  for (const auto& [sensor, axes] : options_.axes) turn_axes(sensors, sensor, axes);
  for (const std::string& note : sensors.notes) event(note);
  checks_.emplace(LiveChecksOptions{.mag_names = lines_.mag_names(),
                                    .file_units = lines_.file_units(),
                                    .dip_sign = options_.estimator.dip_sign,
                                    .set_aside_is_said = true});
}

// Before the estimator gets it: its axes are made ours, and its faults are looked for.
void StreamSession::look_at(StreamSample& sample) {
  for (const auto& [sensor, axes] : options_.axes) {
    turn_axes(sample, lines_.mag_names(), sensor, axes);
  }
  feel_turning(sample);
  checks_->add(sample);
  tell_news();
}

// About which axis it is being turned, for who looks for the axis that is meant.
void StreamSession::feel_turning(const StreamSample& sample) {
  if (!sample.gyr || !sample.gyr->allFinite()) return;
  const double share = std::clamp((sample.t - rate_t_) / kMoment_s, 0.0, 1.0);
  rate_ += share * (*sample.gyr - rate_);
  rate_t_ = sample.t;
  Eigen::Index axis = 0;
  const double most = rate_.cwiseAbs().maxCoeff(&axis);
  const bool clear = rate_.norm() > kTurningRate && most > kMostlyOneAxis * rate_.norm();
  status_.turning = clear ? int(axis) : -1;
}

void StreamSession::tell_news() {
  if (!checks_) return;
  const std::vector<std::string> news = checks_->take_news();
  for (const std::string& sentence : news) event(sentence);
  if (!news.empty() || checks_->issues().size() != status_.issues.size()) set_issues();
}

// Nothing can be estimated from samples without times: that is shown without a window.
void StreamSession::tell_refused_times() {
  const std::optional<RefusedTimes>& refused = lines_.refused_times();
  const std::string text = refused ? refused->problem + "; " + refused->remedy + "." : "";
  if (text == refused_) return;
  refused_ = text;
  event(refused ? text : "The times are understood now.");
  set_issues();
  keep_window();
}

void StreamSession::set_issues() {
  status_.issues = checks_ ? checks_->issues() : std::vector<Issue>();
  if (const std::optional<RefusedTimes>& refused = lines_.refused_times()) {
    status_.issues.insert(status_.issues.begin(), {"time_unit", "t", -1, Severity::kFatal, 0.0, 0.0,
                                                   refused->problem, refused->remedy});
  }
}

void StreamSession::judge_update(StreamUpdate& update) {
  if (!checks_) return;
  if (update.theta) {
    checks_->judge(*update.theta);
    tell_news();
  }
  apps::judge_update(update, *checks_);
}

}  // namespace magimu::apps

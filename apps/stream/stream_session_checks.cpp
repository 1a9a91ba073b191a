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

std::vector<std::string> StreamSession::used_mag_names() const {
  std::vector<std::string> out;
  for (std::size_t m = 0; m < lines_.mag_names().size(); ++m) {
    if (used_[m] != 0) out.push_back(lines_.mag_names()[m]);
  }
  return out;
}

StreamSample StreamSession::used_of(StreamSample sample) const {
  std::size_t used = 0;
  for (std::size_t m = 0; m < sample.mag.size(); ++m) {
    if (used_[m] != 0) sample.mag[used++] = sample.mag[m];
  }
  sample.mag.resize(used);
  return sample;
}

// Magnetometers that never measured are left out from now on, and of all before.
void StreamSession::go_on_without_dead(bool last_comes_next) {
  std::vector<char> used = used_;
  for (std::size_t m = 0; m < used.size(); ++m) used[m] = checks_->is_left_out(m) ? 0 : 1;
  if (used == used_) return;
  used_ = used;
  const auto magnetometers = int(std::ranges::count(used_, 1));
  estimator_.emplace(magnetometers, options_.estimator);
  thinned_ = {};
  if (options_.keep_for_report) thinned_.begin(magnetometers);
  const auto again = [&](const StreamSample& sample) {
    const StreamSample its = used_of(sample);
    estimator_->add(its);
    thinned_.add(its);
  };
  if (!journal_) {
    const std::deque<StreamSample>& looked_at = checks_->samples();
    const std::size_t n = looked_at.size() - (last_comes_next ? 1 : 0);
    for (std::size_t k = 0; k < n; ++k) again(looked_at[k]);
    return;
  }
  journal_->commit();
  journal_.reset();
  journal_ = std::make_unique<SampleJournal>(options_.state, *journal_identity(options_.state));
  while (const std::optional<StreamSample> sample = journal_->replay()) again(*sample);
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

// SPDX-License-Identifier: BSD-3-Clause
// The loop of a stream. A window is shown only once its samples are on the disk; a source that is
// faster than a disk has several windows committed together.
#include "apps/stream_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <utility>

#include "calibration/trust.h"
#include "recording/axes.h"
#include "recording/error.h"
#include "recording/row_times.h"

namespace magimu::apps {
namespace {

using namespace std::chrono_literals;

constexpr auto kTick = 100ms;          // between looks at the source, and pictures of it
constexpr std::size_t kNewClock = 10;  // samples in a row that no source sends again
constexpr auto kCommit = 200ms;        // between commits of a source that leaves no time
// A turn by hand, about one axis: for so long, so fast, so much of it about that axis.
constexpr double kMoment_s = 0.3, kTurningRate = 0.35, kMostlyOneAxis = 0.85;
constexpr const char* kEstimate = ".estimate";  // behind the name of the state
constexpr long kKeptEvery = 16;  // the estimate is kept when it has so much more: a 16th

double seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

// What the estimate depends on, besides the samples.
std::string options_text(const StreamingOptions& o) {
  const std::string noise =
      o.noise ? fmt::format("{} {} {}", o.noise->acc, o.noise->gyr, o.noise->mag) : "estimated";
  return fmt::format("window {} s, noise {}, gravity {}, motion {}", o.window_s, noise, o.gravity,
                     to_string(o.motion));
}

}  // namespace

StreamSession::StreamSession(const StreamSessionOptions& options)
    : options_(options), lines_(options.address.text, options.lines) {
  status_.source = options.address.text;
  status_.target = target_progress(options.estimator.target, {});
  options_.estimator.known_fault = [this](double begin_s, double end_s) {
    return checks_ ? checks_->explanation(begin_s, end_s) : std::string();
  };
}

void StreamSession::run(const std::function<bool()>& stopped) {
  resume();
  if (lines_.has_header()) {
    begin_checks();
    begin_estimator(int(lines_.mag_names().size()));
  }
  StreamSource source(options_.address, options_.source);
  heard_ = Clock::now();
  while (ended_.empty()) {
    Arrival arrival = source.next(0ms);
    if (arrival.kind == Arrival::Kind::kNothing) {
      acknowledge();
      arrival = source.next(kTick);
    }
    take_arrival(arrival);
    if (Clock::now() - committed_ > kCommit) acknowledge();
    tick();
    if (ended_.empty() && stopped()) {
      lines_.interrupt();  // half a line is none
      end("stopped by a signal: finishing (a second one quits at once, without the calibration)");
    }
  }
  lines_.finish();
  use_lines();
  if (!doubtful_.empty()) go_on();
  if (checks_) checks_->look();
  tell_news();
  say_what_was_known();
  event(ended_);
  if (journal_) journal_->commit();
  acknowledge();
  ticked_ = {};
  tick();
}

// The estimate as it was kept, a little earlier; false: there is none, and nothing has been read.
bool StreamSession::take_up() {
  std::ifstream kept(options_.state + kEstimate, std::ios::binary);
  if (!kept) return false;
  const bool taken = estimator_->take_up(kept, [this] {
    std::optional<StreamSample> sample = journal_->replay();
    if (sample) know(*sample);
    return sample;
  });
  keep_at_ = std::max(kFirstKept, samples_ + samples_ / kKeptEvery);
  if (taken) return true;
  samples_ = 0;
  known_ = {};
  known_until_.reset();
  const JournalIdentity identity = *journal_identity(options_.state);
  journal_.reset();
  estimator_.reset();
  begin_estimator(identity.magnetometers);
  return false;
}

// Beside the samples, from time to time: what comes after it is little, whatever comes before. It
// may be lost or damaged, so that nobody waits for the disk; the samples are what counts.
void StreamSession::keep_estimate() {
  if (!journal_ || samples_ < keep_at_) return;
  keep_at_ = samples_ + samples_ / kKeptEvery;
  const std::string path = options_.state + kEstimate, next = path + ".new";
  std::ofstream out(next, std::ios::binary | std::ios::trunc);
  const bool kept = out && estimator_->save(out);
  out.close();
  std::error_code ignored;
  if (kept && out) {
    std::filesystem::rename(next, path, ignored);
  } else {
    std::filesystem::remove(next, ignored);
  }
}

void StreamSession::know(const StreamSample& sample) {
  ++samples_;
  thinned_.add(sample);
  known_.add(sample);
  known_until_ = std::max(known_until_.value_or(sample.t), sample.t);
}

// What the state file remembers goes through the estimator again, unseen.
void StreamSession::resume() {
  if (options_.state.empty()) return;
  const std::optional<JournalIdentity> identity = journal_identity(options_.state);
  if (!identity) return;
  begin_estimator(identity->magnetometers);
  const long known = journal_->samples();
  take_up();
  std::optional<StreamUpdate> last;
  while (const std::optional<StreamSample> sample = journal_->replay()) {
    if (auto update = estimator_->add(*sample)) last = std::move(update);
    know(*sample);
    if (samples_ % 1000 != 0) continue;
    for (StreamObserver* o : observers_) o->replaying(double(samples_) / double(known));
  }
  if (last) set_update(std::move(*last), 0.0);
  if (!known_until_) return;
  event(fmt::format("{} goes on after {} samples, up to {:.6g} s", options_.state, known,
                    *known_until_));
}

void StreamSession::begin_estimator(int magnetometers) {
  const JournalIdentity identity{magnetometers,
                                 options_text(options_.estimator) + options_.reading};
  if (journal_) journal_->require(identity);
  if (estimator_) return;
  if (options_.keep_for_report) thinned_.begin(magnetometers);
  if (!options_.state.empty()) {
    journal_ = std::make_unique<SampleJournal>(options_.state, identity);
  }
  estimator_.emplace(magnetometers, options_.estimator);
}

void StreamSession::take_arrival(const Arrival& arrival) {
  switch (arrival.kind) {
    case Arrival::Kind::kNothing:
      return watch_silence();
    case Arrival::Kind::kBytes: {
      source_speaks();
      const bool had_header = lines_.has_header();
      lines_.push(arrival.bytes);
      if (!had_header && lines_.has_header()) {
        for (const std::string& note : lines_.notes()) event(note);
        begin_checks();
        begin_estimator(int(lines_.mag_names().size()));
      }
      return use_lines();
    }
    case Arrival::Kind::kInterrupted:
      lines_.interrupt();
      return source_is_silent(fmt::format("{}: {}", status_.source, arrival.sentence));
    case Arrival::Kind::kLost:
      status_.lost_bytes += arrival.lost;
      return event(fmt::format("{}: {}", status_.source, arrival.sentence));
    case Arrival::Kind::kEnd:
      return end("the source has ended");
  }
}

void StreamSession::source_speaks() {
  if (std::exchange(status_.silent, false)) {
    event(fmt::format("{} is back after {:.1f} s", status_.source, seconds(Clock::now() - heard_)));
  }
  status_.silent_s = 0.0;
  heard_ = Clock::now();
}

void StreamSession::source_is_silent(const std::string& sentence) {
  event(sentence);
  if (std::exchange(status_.silent, true)) return;
  keep_window();
  acknowledge();
}

void StreamSession::watch_silence() {
  status_.silent_s = seconds(Clock::now() - heard_);
  if (status_.silent_s > options_.give_up_s) {
    return end(fmt::format("nothing came for {:g} s", options_.give_up_s));
  }
  if (status_.silent || status_.silent_s < options_.timeout_s) return;
  source_is_silent(
      fmt::format("nothing has come from {} for {:g} s", status_.source, options_.timeout_s));
}

void StreamSession::use_lines() {
  for (const std::string& sentence : lines_.take_complaints()) event(sentence);
  for (StreamSample& sample : lines_.take()) {
    look_at(sample);
    use(sample);
  }
  tell_refused_times();
  status_.lines = lines_.counts();
}

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

// Wrong units and the like: whatever the estimate says, it is not to be believed.
void StreamSession::judge_update(StreamUpdate& update) {
  if (!checks_) return;
  if (update.theta) {
    checks_->judge(*update.theta);
    tell_news();
  }
  if (const Issue* wrong = checks_->fatal()) {
    if (update.phase == StreamPhase::kConverged) update.phase = StreamPhase::kCalibrating;
    update.axis = -1;
    update.missing.clear();
    if (!update.theta) return;
    Trust& trust = update.theta->trust;
    trust.verdict = Verdict::kNo;
    trust.reasons.insert(trust.reasons.begin(), wrong->text());
  } else if (update.theta) {
    name_faults_first(update.theta->trust, checks_->faults());
  }
}

void StreamSession::use(const StreamSample& sample) {
  if (goes_on_ || !known_until_) return use_new(sample);
  // The state has it; or it had the moment, but not this line of a source that sends again.
  const bool is_known = known_.contains(sample);
  if (is_known || (status_.known_samples > 0 && sample.t <= *known_until_)) {
    status_.known_samples += 1 + long(doubtful_.size());
    doubtful_.clear();
    return;
  }
  doubtful_.push_back(sample);
  if (sample.t > *known_until_ || doubtful_.size() >= kNewClock) go_on();
}

void StreamSession::use_new(StreamSample sample) {
  if (!ended_.empty() && options_.until_converged) return;
  say_what_was_known();
  sample.t += clock_s_;
  const auto begin = Clock::now();
  std::optional<StreamUpdate> update = estimator_->add(sample);
  const double latency_us = 1e6 * seconds(Clock::now() - begin);
  if (journal_) journal_->append(sample);
  thinned_.add(sample);
  ++samples_;
  if (!update) return;
  set_update(std::move(*update), latency_us);
  for (const std::string& sentence : status_.update->events) event(sentence);
  keep_window();
  if (options_.until_converged && status_.update->phase == StreamPhase::kConverged) {
    end("the target is met");
  }
}

void StreamSession::set_update(StreamUpdate update, double latency_us) {
  if (update.theta && lines_.has_header()) update.theta->mag_names = lines_.mag_names();
  if (status_.update && update.t > status_.update->t) {
    status_.rate_hz =
        double(update.samples - status_.update->samples) / (update.t - status_.update->t);
  }
  status_.latency_us = latency_us;
  judge_update(update);
  status_.target = target_progress(options_.estimator.target, update);
  status_.update = std::move(update);
}

void StreamSession::say_what_was_known() {
  if (status_.known_samples == 0 || std::exchange(said_what_was_known_, true)) return;
  event(fmt::format("{} samples up to {:.6g} s are skipped: {} has them already",
                    status_.known_samples, *known_until_, options_.state));
}

// With samples that the state has not. A device that was switched on again counts its time from
// zero: a new part of the same calibration.
void StreamSession::go_on() {
  goes_on_ = true;
  known_ = {};
  const std::vector<StreamSample> first = std::exchange(doubtful_, {});
  if (!first.empty() && first.front().t <= *known_until_) {
    clock_s_ = *known_until_ + kPartGap - first.front().t;
    event(fmt::format(
        "the clock of {} goes on at {:.6g} s where {} has samples up to {:.6g} s (the board was "
        "reset?): a new part begins, its times go on at {:.6g} s",
        status_.source, first.front().t, options_.state, *known_until_, *known_until_ + kPartGap));
  }
  for (const StreamSample& sample : first) use_new(sample);
}

void StreamSession::event(const std::string& sentence) {
  events_.push_back(sentence);
  for (StreamObserver* o : observers_) o->event(sentence);
}

void StreamSession::keep_window() {
  status_.lines = lines_.counts();
  waiting_.push_back({status_, std::exchange(events_, {})});
}

void StreamSession::acknowledge() {
  if (waiting_.empty()) return;
  if (journal_) journal_->commit();
  committed_ = Clock::now();
  for (const Window& w : std::exchange(waiting_, {})) {
    for (StreamObserver* o : observers_) o->window(w.status, w.events);
  }
  keep_estimate();
}

void StreamSession::tick() {
  const auto now = Clock::now();
  if (now - ticked_ < kTick) return;
  ticked_ = now;
  status_.elapsed_s = seconds(now - begin_);
  status_.lines = lines_.counts();
  for (StreamObserver* o : observers_) o->tick(status_);
}

void StreamSession::refuse_fatal() const {
  if (const std::optional<RefusedTimes>& refused = lines_.refused_times()) {
    throw InputError(options_.address.text, 0, 0, refused->problem, refused->remedy);
  }
  const Issue* wrong = checks_ ? checks_->fatal() : nullptr;
  // Axes are judged with the calibration, as calibrate() does.
  if (wrong == nullptr || wrong->kind == "axes") return;
  throw InputError(options_.address.text, 0, 0, wrong->problem, wrong->remedy);
}

Calibration StreamSession::finish() {
  Calibration c = estimator_->finish();
  if (lines_.has_header()) c.mag_names = lines_.mag_names();
  if (!checks_) return c;
  for (const Issue& issue : checks_->issues()) {
    const std::string text = "stream: " + issue.text();
    const bool said = std::ranges::find(c.warnings, text) != c.warnings.end();
    if (issue.severity == Severity::kCaution && issue.kind != "axes" && !said) {
      c.warnings.push_back(text);
    }
  }
  name_faults_first(c.trust, checks_->faults());
  return c;
}

}  // namespace magimu::apps

// SPDX-License-Identifier: BSD-3-Clause
// The loop of a stream. A window is shown only once its samples are on the disk; a source that is
// faster than a disk has several windows committed together.
#include "apps/stream/stream_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "apps/stream/stream_judge.h"
#include "recording/data/error.h"
#include "recording/data/well_formed.h"

namespace magimu::apps {
namespace {

using namespace std::chrono_literals;

constexpr auto kTick = 100ms;          // between looks at the source, and pictures of it
constexpr std::size_t kNewClock = 10;  // samples in a row that no source sends again
constexpr auto kCommit = 200ms;        // between commits of a source that leaves no time

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
  if (checks_ && estimator_) go_on_without_dead(false);
  tell_news();
  say_what_was_known();
  event(ended_);
  if (journal_) journal_->commit();
  acknowledge();
  ticked_ = {};
  tick();
}

void StreamSession::begin_estimator(int magnetometers) {
  const JournalIdentity identity{magnetometers,
                                 options_text(options_.estimator) + options_.reading};
  if (journal_) journal_->require(identity);
  if (estimator_) return;
  used_.assign(std::size_t(magnetometers), 1);
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
      lines_.push(arrival.bytes);
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
  // The header may be known only when the source ends: a short one's dialect is told by all of it.
  if (lines_.has_header() && !checks_) {
    for (const std::string& note : lines_.notes()) event(note);
    begin_checks();
    begin_estimator(int(lines_.mag_names().size()));
  }
  // Who stops when the target is met stops within a line of the source.
  const bool stopped = !ended_.empty() && options_.until_converged;
  for (const std::string& sentence : lines_.take_complaints()) {
    if (!stopped) event(sentence);
  }
  for (StreamSample& sample : lines_.take()) {
    look_at(sample);
    go_on_without_dead(true);
    use(sample);
  }
  tell_refused_times();
  status_.lines = lines_.counts();
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
  const StreamSample used = used_of(sample);
  std::optional<StreamUpdate> update = estimator_->add(used);
  const double latency_us = 1e6 * seconds(Clock::now() - begin);
  if (journal_) journal_->append(sample);
  thinned_.add(used);
  for (StreamObserver* o : observers_) o->sample(sample);
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
  if (update.theta && lines_.has_header()) update.theta->mag_names = used_mag_names();
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

Recording StreamSession::for_report(const Calibration& c) const {
  Recording out;
  out.name = thinned_.recording().name;
  const std::vector<std::string> names =
      lines_.has_header() ? used_mag_names() : thinned_.recording().mag_names;
  for (const std::string& name : c.mag_names) {
    const auto m = std::size_t(std::ranges::find(names, name) - names.begin());
    if (m >= thinned_.recording().mag.size()) continue;
    out.mag.push_back(thinned_.recording().mag[m]);
    out.mag_names.push_back(name);
  }
  return out;
}

Calibration StreamSession::finish() {
  Calibration c = estimator_->finish();
  if (lines_.has_header()) {
    const std::vector<std::string> names = used_mag_names(), usual = usual_mag_names(names.size());
    for (std::string& name : c.mag_names) {  // it may have left out one that hung later
      const auto at = std::ranges::find(usual, name);
      if (at != usual.end()) name = names[std::size_t(at - usual.begin())];
    }
  }
  if (!checks_) return c;
  judge_end(c, *checks_);
  return c;
}

}  // namespace magimu::apps

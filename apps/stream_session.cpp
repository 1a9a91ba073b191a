// SPDX-License-Identifier: BSD-3-Clause
// The loop of a stream. A window is shown only once its samples are on the disk; a source that is
// faster than a disk has several windows committed together.
#include "apps/stream_session.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <utility>

#include "recording/error.h"

namespace magimu::apps {
namespace {

using namespace std::chrono_literals;

constexpr auto kTick = 100ms;                   // between looks at the source, and pictures of it
constexpr const char* kEstimate = ".estimate";  // behind the name of the state
constexpr long kKeptEvery = 16;  // the estimate is kept when it has so much more: a 16th
constexpr auto kCommit = 200ms;  // between commits of a source that leaves no time

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
}

void StreamSession::run(const std::function<bool()>& stopped) {
  resume();
  if (lines_.has_header()) begin_estimator(int(lines_.mag_names().size()));
  StreamSource source(options_.address, options_.source);
  heard_ = new_ = Clock::now();
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
    if (sample) ++samples_;
    return sample;
  });
  keep_at_ = std::max(kFirstKept, samples_ + samples_ / kKeptEvery);
  if (taken) return true;
  samples_ = 0;
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
    if (++samples_ % 1000 != 0) continue;
    for (StreamObserver* o : observers_) o->replaying(double(samples_) / double(known));
  }
  known_until_ = journal_->last_t();
  if (last) set_update(std::move(*last), 0.0);
  if (!known_until_) return;
  event(fmt::format("{} goes on after {} samples, up to {:.6g} s", options_.state, known,
                    *known_until_));
}

void StreamSession::begin_estimator(int magnetometers) {
  const JournalIdentity identity{magnetometers, options_text(options_.estimator)};
  if (journal_) journal_->require(identity);
  if (estimator_) return;
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
  for (const StreamSample& sample : lines_.take()) use(sample);
  status_.lines = lines_.counts();
}

void StreamSession::use(const StreamSample& sample) {
  if (known_until_ && sample.t <= *known_until_) {
    ++status_.known_samples;
    return say_all_is_known(sample.t);
  }
  if (!ended_.empty() && options_.until_converged) return;
  say_what_was_known();
  const auto begin = Clock::now();
  std::optional<StreamUpdate> update = estimator_->add(sample);
  const double latency_us = 1e6 * seconds(Clock::now() - begin);
  if (journal_) journal_->append(sample);
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
  status_.target = target_progress(options_.estimator.target, update);
  status_.update = std::move(update);
}

void StreamSession::say_what_was_known() {
  if (status_.known_samples == 0 || std::exchange(said_what_was_known_, true)) return;
  event(fmt::format("{} samples up to {:.6g} s are skipped: {} has them already",
                    status_.known_samples, *known_until_, options_.state));
}

// A device that was switched on again counts its time from zero.
void StreamSession::say_all_is_known(double t) {
  if (said_all_is_known_ || seconds(Clock::now() - new_) < options_.timeout_s) return;
  said_all_is_known_ = true;
  event(fmt::format(
      "all samples so far (up to {:.6g} s) are older than what {} has (up to {:.6g} s): if the "
      "clock of the device was set back, start again with another --state",
      t, options_.state, *known_until_));
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

Calibration StreamSession::finish() {
  Calibration c = estimator_->finish();
  if (lines_.has_header()) c.mag_names = lines_.mag_names();
  return c;
}

}  // namespace magimu::apps

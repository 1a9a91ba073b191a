// SPDX-License-Identifier: BSD-3-Clause
// A stream from its source to its calibration: bytes to samples to estimates, remembered on the way
// (--state), told to whom it concerns (StreamObserver), until the source or the user ends it.
#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/channels/stream_source.h"
#include "apps/stream/stream_known.h"
#include "apps/stream/stream_status.h"
#include "apps/stream/stream_thinned_samples.h"
#include "calibration/live/checks/live_checks.h"
#include "recording/live/sample_journal.h"

namespace magimu::apps {

struct StreamSessionOptions {
  StreamAddress address;
  StreamSourceOptions source;
  SampleLinesOptions lines;
  StreamingOptions estimator;
  std::string state;       // file; empty: nothing is remembered
  double timeout_s = 5.0;  // without a byte, and the source counts as silent
  double give_up_s = std::numeric_limits<double>::infinity();  // ... as ended
  bool until_converged = false;
  // Sensors whose axes are not ours, and what their readings are multiplied by
  // (recording/data/axes.h).
  std::vector<std::pair<std::string, Matrix3>> axes;
  // How the source is read, in words: with another state its samples do not mix.
  std::string reading;
  bool keep_for_report = false;  // samples for the pictures of a report
};

class StreamSession {
 public:
  explicit StreamSession(const StreamSessionOptions& options);

  void add_observer(StreamObserver& observer) { observers_.push_back(&observer); }
  // Until the source ends, end() is called or `stopped` says so. InputError where the source or the
  // state cannot be used; what has come before can be finished all the same.
  void run(const std::function<bool()>& stopped);
  void end(const std::string& why) { ended_ = why; }

  // Is there anything to estimate from?
  bool has_samples() const { return samples_ > 0; }
  // Throws what calibrate() would of these samples: wrong units, times that cannot be told.
  void refuse_fatal() const;
  // The calibration of all samples so far.
  Calibration finish();
  // The samples of this calibration's magnetometers, thinned: what a report's pictures show.
  Recording for_report(const Calibration& c) const;

 private:
  using Clock = std::chrono::steady_clock;
  // Fewer samples go through the estimator again within a tenth of a second.
  static constexpr long kFirstKept = 10000;
  struct Window {
    StreamStatus status;
    std::vector<std::string> events;
  };

  void resume();
  bool take_up();
  void know(const StreamSample& sample);
  void keep_estimate();
  void begin_estimator(int magnetometers);
  void take_arrival(const Arrival& arrival);
  void source_speaks();
  void source_is_silent(const std::string& sentence);
  void watch_silence();
  void begin_checks();
  void use_lines();
  void look_at(StreamSample& sample);
  std::vector<std::string> used_mag_names() const;
  StreamSample used_of(StreamSample sample) const;
  void go_on_without_dead(bool last_comes_next);
  void feel_turning(const StreamSample& sample);
  void tell_news();
  void tell_refused_times();
  void set_issues();
  void judge_update(StreamUpdate& update);
  void use(const StreamSample& sample);
  void use_new(StreamSample sample);
  void go_on();
  void set_update(StreamUpdate update, double latency_us);
  void say_what_was_known();
  void event(const std::string& sentence);
  void keep_window();
  void acknowledge();
  void tick();

  StreamSessionOptions options_;
  std::vector<StreamObserver*> observers_;
  SampleLines lines_;
  std::optional<StreamingCalibration> estimator_;
  std::unique_ptr<SampleJournal> journal_;
  std::optional<LiveChecks> checks_;
  ThinnedSamples thinned_;
  Vector3 rate_ = Vector3::Zero();  // of turn, mean of a moment, rad/s
  double rate_t_ = 0.0;
  std::string refused_;                 // times that could not be told: what was said of them
  KnownSamples known_;                  // those of the state
  std::optional<double> known_until_;   // s: the latest of them
  std::vector<StreamSample> doubtful_;  // not known, though not later than those
  bool goes_on_ = false;                // the source has sent samples that the state has not
  double clock_s_ = 0.0;                // what is added to the source's times since then
  bool said_what_was_known_ = false;
  std::vector<char> used_;     // of the source's magnetometers those that the estimator has
  long samples_ = 0;           // in the estimator
  long keep_at_ = kFirstKept;  // samples from which on the estimate is kept (again)

  StreamStatus status_;
  std::vector<std::string> events_;  // since the last window
  std::vector<Window> waiting_;      // for the state to be on the disk
  Clock::time_point begin_ = Clock::now(), heard_ = begin_, committed_, ticked_;
  std::string ended_;
};

}  // namespace magimu::apps

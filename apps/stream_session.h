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

#include "apps/stream_source.h"
#include "apps/stream_status.h"
#include "recording/sample_journal.h"

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
  // The calibration of all samples so far.
  Calibration finish();

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
  void keep_estimate();
  void begin_estimator(int magnetometers);
  void take_arrival(const Arrival& arrival);
  void source_speaks();
  void source_is_silent(const std::string& sentence);
  void watch_silence();
  void use_lines();
  void use(const StreamSample& sample);
  void set_update(StreamUpdate update, double latency_us);
  void say_what_was_known();
  void say_all_is_known(double t);
  void event(const std::string& sentence);
  void keep_window();
  void acknowledge();
  void tick();

  StreamSessionOptions options_;
  std::vector<StreamObserver*> observers_;
  SampleLines lines_;
  std::optional<StreamingCalibration> estimator_;
  std::unique_ptr<SampleJournal> journal_;
  std::optional<double> known_until_;  // s: samples up to there come from the state
  bool said_what_was_known_ = false, said_all_is_known_ = false;
  long samples_ = 0;           // in the estimator
  long keep_at_ = kFirstKept;  // samples from which on the estimate is kept (again)

  StreamStatus status_;
  std::vector<std::string> events_;  // since the last window
  std::vector<Window> waiting_;      // for the state to be on the disk
  Clock::time_point begin_ = Clock::now(), heard_ = begin_, new_ = begin_, committed_, ticked_;
  std::string ended_;
};

}  // namespace magimu::apps

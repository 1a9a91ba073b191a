// SPDX-License-Identifier: BSD-3-Clause
// How a stream stands, for those who show it: JSON lines, the live view, the log.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/stream/stream_target.h"
#include "calibration/live/streaming.h"
#include "recording/checks/quality.h"
#include "recording/live/sample_lines.h"

namespace magimu::apps {

struct StreamStatus {
  std::string source;
  bool silent = false;                 // nothing comes from the source at present
  double silent_s = 0.0;               // for so long
  double elapsed_s = 0.0;              // since the program began
  std::optional<StreamUpdate> update;  // of the last full window
  std::vector<TargetProgress> target;
  double latency_us = 0.0;  // from that window's last sample to its update
  double rate_hz = 0.0;     // samples a second of the source's clock
  SampleLines::Counts lines;
  long lost_bytes = 0;        // which the source could not keep
  long known_samples = 0;     // skipped: the state had them already
  std::vector<Issue> issues;  // faults of the samples that stand, the gravest first
  int turning = -1;           // the axis about which it is being turned now: 0, 1, 2; -1: none

  // The fault with which no calibration can be believed; null: none is known.
  const Issue* fatal() const {
    const bool any = !issues.empty() && issues.front().severity == Severity::kFatal;
    return any ? &issues.front() : nullptr;
  }
  // What to do: about that fault first, else as the estimate has it.
  std::string guidance() const;
  std::string headline() const;
};

class StreamObserver {
 public:
  virtual ~StreamObserver() = default;
  // A window is complete and, where a state is kept, on the disk; or the source fell silent or came
  // back since. events: sentences since the call before.
  virtual void window(const StreamStatus&, const std::vector<std::string>& /*events*/) {}
  // A sentence for people, as soon as it happens.
  virtual void event(const std::string&) {}
  // A sample as the estimator gets it, its axes made ours.
  virtual void sample(const StreamSample&) {}
  // Several times a second.
  virtual void tick(const StreamStatus&) {}
  // The samples of the state are being gone through again: 0 to 1.
  virtual void replaying(double /*share*/) {}
};

}  // namespace magimu::apps

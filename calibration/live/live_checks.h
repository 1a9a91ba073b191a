// SPDX-License-Identifier: BSD-3-Clause
// What `magimu info` would say of a recording, said of a stream while it runs: units, axes, clipped
// and hung sensors, gaps, rates. The samples of the last minute are looked at as a recording, by
// the same checks (recording/checks/quality.h, mounting.h), after 2, 3, 4, 5, 8, 15 and 30 s and
// then every half minute. A fault is said once, and once more where it has become graver; one that
// the first seconds suggested and the same seconds with more behind them do not is taken back.
//
//   LiveChecks checks({"mag"});
//   checks.add(sample);
//   for (const std::string& sentence : checks.take_news()) print(sentence);
//   if (const Issue* wrong = checks.fatal()) print(wrong->text());
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calibration/result/calibration.h"
#include "calibration/trust/mounting.h"
#include "recording/checks/quality.h"
#include "recording/data/stream_sample.h"

namespace magimu {

struct LiveChecksOptions {
  std::vector<std::string> mag_names = {"mag"};
  // The source's units in ours, as Recording::file_units: what was given is not asked for again.
  std::map<std::string, double> file_units = {};
  // Of the true dip, where it is known (calibrate.h); 0: unknown.
  int dip_sign = 0;
  // Somebody else says what is set aside (streaming.h does), unless next to nothing is left.
  bool set_aside_is_said = false;
};

// Not thread safe.
class LiveChecks {
 public:
  explicit LiveChecks(LiveChecksOptions options = {});

  // A sample as it came, its unit and axes as the user gave them. Rows of some sensors may be late
  // by less than a second; a time that goes back further, or on by many seconds, begins a new part.
  void add(const StreamSample& sample);
  // Looks now, at the end of a stream or where something does not fit; add() does when it is time.
  void look();
  // The estimate so far. With it a magnetometer that is inverted as a whole is told, by the sign of
  // the dip.
  void judge(const Calibration& estimate);

  // Sentences since the last call: faults found, and faults taken back.
  std::vector<std::string> take_news();
  // What stands, the gravest first. Its kinds are those of recording/checks/quality.h, "axes"
  // (fatal where accelerometer and gyroscope disagree, as in check_axes.h), "arrival" (samples
  // stamped when they arrived) and "absent" (a sensor without samples).
  const std::vector<Issue>& issues() const { return issues_; }
  // The first fatal one; null: none.
  const Issue* fatal() const;
  // Faults that a calibration suffers from (damages() in quality.h), in sentences.
  std::vector<KnownFault> faults() const;
  // A fault of the samples that explains why the magnetometer does not fit the rest between these
  // times, in a sentence; empty: none is known. Looks first.
  std::string explanation(double begin_s, double end_s);

 private:
  struct Found {
    Issue issue;
    double first_s = 0.0;  // of the samples in which it was seen
  };

  bool due() const;
  Recording piece() const;
  std::vector<Issue> issues_in(const Recording& piece);
  std::vector<Issue> axes_issues() const;
  void see(const Issue& issue);
  void take_back(const std::vector<Issue>& seen);
  void rank();

  LiveChecksOptions options_;
  std::deque<StreamSample> samples_;
  double begin_s_ = 0.0, latest_s_ = 0.0;  // of this part
  long in_part_ = 0, since_look_ = 0;
  std::size_t next_look_ = 0;
  Mounting mounting_;              // as last looked at
  std::optional<double> dip_rad_;  // of an estimate that is sure of its sign
  std::vector<Found> found_;
  std::vector<Issue> issues_;  // of found_, the gravest first
  std::vector<std::string> news_;
};

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// What `magimu info` would say of a recording, said of a stream while it runs: units, axes, clipped
// and hung sensors, gaps, rates. The samples of the last minute are looked at as a recording, by
// the same checks (recording/checks/quality.h, mounting.h), eleven times in the first 30 s (kLooks
// in live_checks.cpp) and then every 30 s. A sensor that falls silent while the others go on, or
// hangs while they turn, is told within 2 s; a magnetometer of an array that never measures is left
// out, and the others go on. A fault is said once, and once more where it has
// become graver; one that the first seconds suggested and the same seconds with more behind them do
// not is taken back.
//
//   LiveChecks checks({"mag"});
//   checks.add(sample);
//   for (const std::string& sentence : checks.take_news()) print(sentence);
//   if (const Issue* wrong = checks.fatal()) print(wrong->text());
#pragma once

#include <array>
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
  // The source's units in ours, as Recording::file_units: no remedy proposes a unit that was given
  // already.
  std::map<std::string, double> file_units = {};
  // Sign of the true dip (calibrate.h); 0: unknown.
  int dip_sign = 0;
  // Do not report samples that were set aside: the caller does (streaming.h), except where nearly
  // all are.
  bool set_aside_is_said = false;
};

// Not thread safe.
class LiveChecks {
 public:
  explicit LiveChecks(LiveChecksOptions options = {});

  // Adds a sample as it came, in the units and axes that the user gave. Rows of some sensors may be
  // late by less than 1 s. A time that goes back further, or ahead by more than kOtherPart, begins
  // a new part.
  void add(const StreamSample& sample);
  // Looks at the samples now: at the end of a stream, or where something does not fit. add() calls
  // it from time to time.
  void look();
  // Takes the estimate so far: the sign of its dip shows a magnetometer whose axes are all
  // inverted.
  void judge(const Calibration& estimate);

  // Sentences since the last call: faults found, and faults taken back.
  std::vector<std::string> take_news();
  // The issues found so far and not taken back, the gravest first. Their kinds are those of
  // recording/checks/quality.h, "axes"
  // (fatal where accelerometer and gyroscope disagree, as in check_axes.h), "arrival" (samples
  // stamped when they arrived) and "absent" (a sensor without samples).
  const std::vector<Issue>& issues() const { return issues_; }
  // The first fatal one; null: none.
  const Issue* fatal() const;
  // Faults that a calibration suffers from (damages() in quality.h), in sentences.
  std::vector<KnownFault> faults() const;
  // Whether this magnetometer, of those of the options, never measures and is not looked at.
  bool is_left_out(std::size_t m) const { return m < left_out_.size() && left_out_[m] != 0; }
  // The samples that are looked at, as they came.
  const std::deque<StreamSample>& samples() const { return samples_; }
  // The fault of the samples that explains why the magnetometer does not fit between these times,
  // s, in a sentence; empty if none is known. Calls look() first.
  std::string explanation(double begin_s, double end_s);

 private:
  struct Found {
    Issue issue;
    double first_s = 0.0;  // s: time of the first sample of those in which it was seen
  };

  // What was heard of one sensor. Time in which the others were silent, too, does not count.
  struct Heard {
    double new_s = 0.0;      // time of its last sample that was another than the one before
    double longest_s = 0.0;  // between two of them
    double silent_s = 0.0;   // since its last sample
    double turned_s = 0.0;   // turned since the last new one
    std::optional<Vector3> value = {};
    bool told = false;
  };

  // How often each axis of a sensor has given another reading than the one before.
  struct Reading {
    std::array<long, 3> changes = {};
    std::optional<Vector3> last = {};
  };

  bool due() const;
  void listen(const StreamSample& sample);
  // elapsed_s: since the sample before, of any sensor; of that it turned.
  void listen_to(const std::string& name, const std::optional<Vector3>& value, double t,
                 double elapsed_s, double turned_s, Heard& heard);
  void count_readings(const StreamSample& sample);
  void leave_out_dead(std::vector<Issue>& seen);
  void go_on_without_hung(std::vector<Issue>& seen) const;
  bool has_measured(const Issue& issue) const;
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
  std::vector<Heard> heard_;       // accelerometer, gyroscope, magnetometers
  std::vector<Reading> readings_;  // of the same, of all parts
  std::vector<char> left_out_;     // of the magnetometers
  std::vector<Issue> left_out_issues_;
  std::vector<Found> found_;
  std::vector<Issue> issues_;  // of found_, the gravest first
  std::vector<std::string> news_;
};

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// Times at which samples arrived, several at once: a sensor with a queue, a bus or a radio hands
// them over in bursts. The sensor measured at its own steady pace; the last sample of a burst is
// about as old as its stamp says.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace magimu {

struct EvenTimes {
  std::vector<double> t;  // one a sample, increasing
  double rate_hz = 0.0;
  double in_a_burst = 0.0;  // samples, on average
  double burst_s = 0.0;     // from burst to burst, as a rule
  double gap_s = 0.0;       // what is longer is a gap: samples are missing
};

// t: of one sensor's samples, none earlier than the one before. Nothing where they do not come in
// bursts, or come at no steady pace.
std::optional<EvenTimes> even_times(const std::vector<double>& t);

// Such a rate for an option: a whole number of samples a second where it is that to 0.5 %.
std::string rate_text(double rate_hz);

// Of the first of them: may they come in bursts? Then more of them tell (even_times()).
bool may_be_bursts(const std::vector<double>& t);
// The same of times that are not in memory at once: every interval is first added, then counted.
class BriefIntervals {
 public:
  void add(double interval_s);
  void count(double interval_s);
  bool may_be_bursts() const;

 private:
  double sum_ = 0.0;
  std::size_t added_ = 0, counted_ = 0, together_ = 0;
};
// How many of them are in bursts that are whole: without the last one, which may still go on.
std::size_t in_whole_bursts(const std::vector<double>& t);

// Even times for samples of a stream that are stamped on arrival, from what even_times() found in
// its first ones: each a period after the one before, and the bursts' last stamps pull period and
// phase to the clock's, slowly, as a phase-locked loop does.
class EvenPace {
 public:
  // stamps: those that `found` was made of.
  EvenPace(const EvenTimes& found, const std::vector<double>& stamps);
  // The time of the sample that is stamped t.
  double next(double t);

 private:
  double period_, burst_s_, brief_, tolerance_;
  double time_, stamp_;  // of the sample before
};

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// The gate for the samples of one sensor, in files and streams alike: which of them no measurement
// can have given. It needs no unit: sizes are compared with what is usual for this sensor
// (sensor_habits.h), and each reading with four others before it and after it, that is why a sample
// waits for at most seven later ones that differ from it.
//
//   SensorGate gate({.sensor = Sensor::kMag});
//   gate.push(t, v);                                    // again and again, then gate.finish()
//   for (const SensorGate::Judged& s : gate.take()) ... // kind empty: a measurement
//
// A blow to the sensor, a magnet that passes, a current that is switched, an outlier of a sensor
// that has many (jump_sizes.h) are measurements. A jump is one against the course of its neighbours
// (local_course.h): only what departs from them counts.
#pragma once

#include <array>
#include <deque>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "graph/sensor.h"
#include "recording/oddities/jump_sizes.h"
#include "recording/oddities/recurring_jumps.h"
#include "recording/oddities/wrapped_readings.h"

namespace magimu {

class SensorGate {
 public:
  struct Options {
    Sensor sensor = Sensor::kMag;
    // Habits of the sensor in the whole recording; null for a stream, which learns them as it goes.
    const SensorHabits* habits = nullptr;
    // Keep clipped readings, for a search for clipping. Default false.
    bool keep_clipped = false;
    // s: a reading that does not change is judged after this time. A stream cannot wait longer; a
    // file can.
    double longest_wait_s = std::numeric_limits<double>::infinity();
    // Least value for the length of the largest readings: a sensor that was at rest so far has
    // shown no large ones.
    double largest_at_least = 0.0;
    // Whether other sensors show for certain that the device turned between two times, s.
    std::function<bool(double begin_s, double end_s)> turned = {};
    // For a gyroscope: whether other sensors show that the rate was larger by `more` (rad/s, device
    // axes) between two times, s, than before and after.
    std::function<bool(double begin_s, double end_s, const Vector3& more)> turned_by = {};
    // Whether readings of other sensors changed between two times, s.
    std::function<bool(double begin_s, double end_s)> others_change = {};
  };
  struct Judged {
    double t = 0.0;
    Vector3 v;
    std::string kind;         // as in SetAside; empty: it may have been measured
    int axis = 0;             // the axis that shows it most
    double neighbours = 0.0;  // what the neighbours read on that axis
  };

  explicit SensorGate(const Options& options);
  // Habits for the beginning of a stream. They count until the stream itself has had as many
  // samples.
  void begin_with(const SensorHabits& habits);
  // Adds a sample; times must increase.
  void push(double t, const Vector3& v);
  // Judges all samples that wait: no more will come.
  void finish();
  // Samples judged since the last call, in the order of push().
  std::vector<Judged> take() { return std::exchange(done_, {}); }

  // Values that an axis jumped to again and again. A second pass over the samples gets them by
  // know().
  Sentinels sentinels() const { return recurring_.sentinels(); }
  // By how many whole ranges most readings of an axis are off, if the first ones were not.
  std::array<int, 3> usual_turns() const { return wrapped_.usual_turns(); }
  // Number of isolated jumps to different values, farther than heavy-tailed noise takes a reading.
  std::size_t jumps_seen() const { return jumps_seen_; }
  // Sizes of the jumps that were set aside, and of those that stay.
  const JumpSizes& gone() const { return gone_; }
  const JumpSizes& tail() const { return tail_; }
  struct Known {
    Sentinels sentinels;
    std::array<int, 3> first_turns = {0, 0, 0};
    std::size_t jumps_seen = 0;
    JumpSizes sizes;  // of all of them
    bool sizes_known = false;
  };
  void know(const Known& known);

 private:
  struct Waiting {
    Judged sample;
    long unit;  // number of the reading that decides about it; -1: it is decided
  };
  void look_up(const SensorHabits& habits);
  void drain(bool to_the_end);
  std::size_t judge_front();
  std::size_t jumped(Judged& why);
  bool away(const RepeatedReading& unit, const Neighbours& sides, bool in_a_row, Judged& why) const;
  double farthest(int axis) const;
  void find_end_of_tail();
  double size_of_jump(const RepeatedReading& unit, const Neighbours& sides) const;
  bool reads_zero(const RepeatedReading& unit) const;
  bool is_sentinel(const RepeatedReading& unit, Judged& why) const;
  bool wrapped(Judged& why);
  bool at_its_limit(const RepeatedReading& unit, Judged& why) const;
  bool jumps_recur() const;
  bool is_a_turn(const RepeatedReading& unit, const Neighbours& sides) const;
  bool count_jump(const RepeatedReading& unit, const Neighbours& sides);
  void decide(std::size_t units, const std::string& kind, const Judged& why);
  void keep(const RepeatedReading& unit);
  void hand_over();

  Options options_;
  SensorHabits own_;
  std::size_t learnt_ = 0;
  UsualReadings usual_;
  RecurringJumps recurring_;
  std::size_t jumps_seen_ = 0;
  JumpSizes tail_, gone_, known_sizes_;
  bool sizes_known_ = false;
  double end_of_tail_ = 0.0;          // standard deviations of the noise
  RepeatedReadings units_;            // not judged yet
  long first_unit_ = 0;               // number of the first of them
  RepeatedReadings kept_;             // the last ones that were kept
  Vector3 lately_ = Vector3::Zero();  // how far these bend, the older ones less
  std::deque<Waiting> waiting_;
  std::vector<Judged> done_;
  WrappedReadings wrapped_;
};

}  // namespace magimu

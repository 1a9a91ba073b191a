// SPDX-License-Identifier: BSD-3-Clause
// The gate for the samples of one sensor, in files and streams alike: which of them no measurement
// can have given. It needs no unit: sizes are compared with what is usual for this sensor
// (sensor_habits.h), and each reading with four others before it and after it, that is why a sample
// waits for at most seven later ones that differ from it.
//
//   SensorGate gate({.sensor = SensorGate::Sensor::kMag});
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
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "recording/checks/jump_sizes.h"
#include "recording/checks/sensor_habits.h"

namespace magimu {

class SensorGate {
 public:
  enum class Sensor { kAcc, kGyr, kMag };
  struct Options {
    Sensor sensor = Sensor::kMag;
    // Of the whole recording, where it is there; a stream learns them as it goes.
    const SensorHabits* habits = nullptr;
    // Clipped readings are measurements of a kind: whoever looks for them keeps them.
    bool keep_clipped = false;
    // Seconds for which a reading that does not change is waited for; a stream must go on.
    double longest_wait_s = std::numeric_limits<double>::infinity();
    // The largest readings are at least so long, whatever has been seen of them: for a sensor that
    // may have been at rest so far.
    double largest_at_least = 0.0;
    // Whether the device certainly turned from one time to another, as other sensors say.
    std::function<bool(double begin_s, double end_s)> turned = {};
    // Whether they say that the device was turned at so much more, rad/s in its own axes, from one
    // time to another than before and after: of a gyroscope.
    std::function<bool(double begin_s, double end_s, const Vector3& more)> turned_by = {};
    // Whether other sensors' readings changed between two times.
    std::function<bool(double begin_s, double end_s)> others_change = {};
  };
  struct Judged {
    double t = 0.0;
    Vector3 v;
    std::string kind;         // as in SetAside; empty: it may have been measured
    int axis = 0;             // that shows it most
    double neighbours = 0.0;  // what they read on that axis
  };

  explicit SensorGate(const Options& options);
  // Habits to begin with, where there are none of the whole recording: they count until those that
  // are learnt on the way are of as many samples.
  void begin_with(const SensorHabits& habits);
  // Times increase.
  void push(double t, const Vector3& v);
  // No more will come.
  void finish();
  // Those judged since the last call, in the order in which they came.
  std::vector<Judged> take() { return std::exchange(done_, {}); }

  // Values that came again and again on an axis and jumped away each time; for a second pass.
  using Sentinels = std::array<std::vector<double>, 3>;
  Sentinels sentinels() const;
  // By how many whole ranges most readings of an axis are off, if the first ones were not.
  std::array<int, 3> usual_turns() const;
  // Isolated jumps to different values, further than heavy-tailed noise takes a reading.
  std::size_t jumps_seen() const { return jumps_seen_; }
  // Sizes of jumps, those that were set aside and those that stay.
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
  // A reading, and the same again and again.
  struct Unit {
    Vector3 v;
    double begin_s, end_s;
    std::size_t count;
  };
  struct Waiting {
    Judged sample;
    long unit;  // which decides about it; -1: it is decided
  };
  struct Jump {
    double value;
    std::size_t count;
  };
  // What stands around some units.
  struct Sides {
    Vector3 middle, spread;
    Vector3 bend;        // the largest of one of them against the two beside it
    bool before, after;  // two readings and more

    bool both() const { return before && after; }
  };

  // What the habits say, looked up anew when there are many more samples.
  struct Usual {
    std::size_t samples = 0;
    bool settled = false, lively = false;
    Vector3 roughness, noise, extreme, step;
    double length = 0.0, largest = 0.0;
    double repeats = 0.0, same_noise = 0.0;
    std::array<std::optional<double>, 6> limits;  // of x, y, z, upper and lower
  };

  void look_up(const SensorHabits& habits);
  void drain(bool to_the_end);
  std::size_t judge_front();
  std::size_t jumped(Judged& why);
  Sides sides_of(std::size_t run) const;
  bool away(const Unit& unit, const Sides& sides, bool in_a_row, Judged& why) const;
  double farthest(int axis) const;
  void find_end_of_tail();
  double size_of_jump(const Unit& unit, const Sides& sides) const;
  bool reads_zero(const Unit& unit) const;
  bool is_sentinel(const Unit& unit, Judged& why) const;
  bool wrapped(const Unit& unit, Judged& why);
  bool goes_on_from_there(int axis, double most) const;
  void follow(const Unit& unit);
  bool longer_than_chance(const Unit& unit) const;
  bool hung() const;
  bool resumes_elsewhere(const Vector3& usual_change) const;
  bool never_changed() const;
  bool turned_while_still() const;
  bool frozen() const;
  bool at_its_limit(const Unit& unit, Judged& why) const;
  bool jumps_recur() const;
  bool is_a_turn(const Unit& unit, const Sides& sides) const;
  bool count_jumps(const Unit& unit, const Sides& sides);
  void decide(std::size_t units, const std::string& kind, const Judged& why);
  void keep(const Unit& unit);
  void hand_over();

  Options options_;
  SensorHabits own_;
  std::size_t learnt_ = 0;
  Usual usual_;
  Sentinels known_;
  std::array<std::vector<Jump>, 3> jumps_;
  std::size_t jumps_seen_ = 0;
  JumpSizes tail_, gone_, known_sizes_;
  bool sizes_known_ = false;
  double end_of_tail_ = 0.0;          // standard deviations of the noise
  std::deque<Unit> units_;            // not judged yet
  long first_unit_ = 0;               // number of the first of them
  std::deque<Unit> kept_;             // the last ones that were kept
  Vector3 lately_ = Vector3::Zero();  // how far these bend, the older ones less
  std::deque<Waiting> waiting_;
  std::vector<Judged> done_;
  std::array<int, 3> turns_over_ = {0, 0, 0};  // wrapped: by how many whole ranges
  double right_s_ = 0.0;                       // time of the last reading that had not wrapped
  std::array<std::map<int, std::size_t>, 3> turns_seen_;
  std::deque<Vector3> path_;   // the last readings, as if they had not wrapped
  std::deque<double> path_s_;  // their times
  Vector3 last_ = Vector3::Zero();
};

}  // namespace magimu

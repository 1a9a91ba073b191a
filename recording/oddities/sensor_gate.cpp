// SPDX-License-Identifier: BSD-3-Clause
#include "recording/oddities/sensor_gate.h"

#include <algorithm>
#include <cmath>

#include "recording/oddities/hangs.h"

namespace magimu {
namespace {

// No converter counts further than 32 bits, whatever the unit.
constexpr double kBeyondAnyRange = 4294967296.0;

constexpr std::size_t kLongestRun = 3;  // readings of one jump

// An isolated jump, in standard deviations of the noise. Outliers that are noise have up to 30
// times the usual standard deviation; the largest of 1e7 normal numbers is 5.3 of theirs, 160 in
// all. Where jumps of more than that recur, smaller ones are of their kind.
constexpr double kFarthestOutlier = 200.0;
// How far the tail of this sensor's noise reaches is found from readings beyond what a normal
// distribution gives once in 1e9 (jump_sizes.h). Without a tail kSomeJump is enough. In standard
// deviations, and in spreads of neighbours.
constexpr double kTail = 6.0, kTailToSpread = 2.0;
constexpr double kForgetting =
    0.8;  // factor from one reading to the next: about five readings are remembered
// Size of a jump over the spread of its neighbours, on any axis. A blow to the device has a tail,
// by inertia and filters: a twentieth of it is left two samples later. So a larger ratio is no
// blow. The magnetic field has no blows, and the smaller ratio is enough.
constexpr double kBlowToTail = 20.0, kJumpToSpread = 5.0;
// Jumps that are never measurements, even near others or in a row: by more than 32 g (parts reach
// 16 g to either side), ten times the fastest rate, three times the strongest field.
constexpr double kGravities = 32.0, kTimesLargest[] = {3.0, 10.0, 3.0};

constexpr double kZeroJump = 20.0;  // standard deviations: a jump of a gyroscope to 0

constexpr double kAbsurd = 1000.0;     // times the largest reading, isolated or not
constexpr double kLookUpAfter = 1.05;  // times the samples of the last look-up

constexpr double kBelowItsLimit =
    4.0;  // standard deviations: so near the limit noise alone keeps a reading below it

}  // namespace

SensorGate::SensorGate(const Options& options) : options_(options) {
  if (options_.habits != nullptr) look_up(*options_.habits);
}

void SensorGate::begin_with(const SensorHabits& habits) {
  look_up(habits);
  usual_.samples = habits.samples();
}

void SensorGate::look_up(const SensorHabits& habits) {
  usual_.look_up(habits, options_.largest_at_least);
  find_end_of_tail();
}

void SensorGate::know(const Known& known) {
  recurring_.know(known.sentinels);
  wrapped_.begin_with(known.first_turns);
  jumps_seen_ = known.jumps_seen;
  known_sizes_ = known.sizes;
  sizes_known_ = known.sizes_known;
  find_end_of_tail();
}

void SensorGate::push(double t, const Vector3& v) {
  if (!units_.empty() && t - units_.front().begin_s > options_.longest_wait_s) drain(true);
  Waiting next{{t, v, "", 0, 0.0}, -1};
  if (!std::isfinite(t) || !v.allFinite()) {
    next.sample.kind = "not_finite";
    for (int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(v[axis])) next.sample.axis = axis;
    }
  } else if (v.cwiseAbs().maxCoeff(&next.sample.axis) > kBeyondAnyRange) {
    next.sample.kind = "range";
  }
  if (!next.sample.kind.empty()) {
    if (!kept_.empty()) next.sample.neighbours = kept_.back().v[next.sample.axis];
    waiting_.push_back(next);
    if (units_.empty()) hand_over();
    return;
  }
  if (units_.empty() || units_.back().v != v) {
    units_.push_back({v, t, t, 0});
    drain(false);
  }
  RepeatedReading& unit = units_.back();
  ++unit.count;
  unit.end_s = t;
  next.unit = first_unit_ + long(units_.size()) - 1;
  waiting_.push_back(next);
}

void SensorGate::finish() {
  drain(true);
  hand_over();
}

// Judges readings that have enough others after them.
void SensorGate::drain(bool to_the_end) {
  // The last one may still be repeated.
  while (units_.size() > kSide + kLongestRun || (to_the_end && !units_.empty())) {
    first_unit_ += long(judge_front());
  }
  hand_over();
}

std::size_t SensorGate::judge_front() {
  const RepeatedReading& front = units_.front();
  Judged why;
  const auto judged = [&](std::size_t run, const char* kind) {
    decide(run, kind, why);
    return run;
  };
  if (reads_zero(front)) return judged(1, "zeros");
  if (usual_.settled) {
    if (is_sentinel(front, why)) return judged(1, "sentinel");
    if (front.v.cwiseAbs().maxCoeff(&why.axis) > kAbsurd * usual_.largest) {
      if (!kept_.empty()) why.neighbours = kept_.back().v[why.axis];
      return judged(1, "range");
    }
    if (const std::size_t run = jumped(why); run > 0) return judged(run, "spike");
    if (wrapped(why)) return judged(1, "wrap");
    if (hangs({kept_, units_}, usual_, {options_.turned, options_.others_change})) {
      keep({front.v, front.begin_s, front.begin_s, 1});
      return judged(1, "stuck");
    }
    if (at_its_limit(front, why)) {
      wrapped_.follow(front, usual_);
      return judged(1, "clipped");
    }
  }
  wrapped_.follow(front, usual_);
  keep(front);
  return judged(1, "");
}

// How many of the first readings are isolated jumps; 0: the first one is none.
std::size_t SensorGate::jumped(Judged& why) {
  if (!kept_.empty() &&
      units_.size() > 1) {  // a short cut: nearly all readings are near their neighbours
    const Vector3 mean = 0.5 * (kept_.back().v + units_[1].v);
    const Vector3 bend = (units_.front().v - mean).cwiseAbs();
    if ((bend.array() <= 0.5 * kSomeJump * usual_.roughness.array()).all()) return 0;
  }
  const Neighbours sides = neighbours_of({kept_, units_}, 1);
  const bool new_value = count_jump(units_.front(), sides);
  const double size = size_of_jump(units_.front(), sides);
  const bool gone = away(units_.front(), sides, false, why);
  if (size > 0.0) {
    (gone ? gone_ : tail_).add(size);
    if (options_.habits == nullptr) find_end_of_tail();
  }
  if (gone) {
    jumps_seen_ += new_value ? 1 : 0;
    return 1;
  }
  for (std::size_t run = 2; run <= std::min(kLongestRun, units_.size()); ++run) {
    const Neighbours around = neighbours_of({kept_, units_}, run);
    bool all = true;
    for (std::size_t i = run; i-- > 0 && all;) all = away(units_[i], around, true, why);
    if (all) return run;
  }
  return 0;
}

// Size from which an isolated jump is no measurement, in the sensor's unit.
double SensorGate::farthest(int axis) const {
  const double some = kSomeJump * usual_.roughness[axis];
  return jumps_recur() ? some : std::max(some, end_of_tail_ * usual_.noise[axis]);
}

// Size of a jump in standard deviations of the noise; 0 if it may be motion.
double SensorGate::size_of_jump(const RepeatedReading& unit, const Neighbours& sides) const {
  double size = 0.0;
  bool isolated = false;
  for (int axis = 0; axis < 3 && sides.both(); ++axis) {
    const double jump = std::abs(unit.v[axis] - sides.middle[axis]);
    size = std::max(size, jump / usual_.noise[axis]);
    isolated = isolated ||
               jump > std::max(kTail * usual_.roughness[axis], kTailToSpread * sides.spread[axis]);
  }
  return isolated ? size : 0.0;
}

// The first pass over a file knows no sizes yet; a stream knows those so far.
void SensorGate::find_end_of_tail() {
  end_of_tail_ = kFarthestOutlier;
  if (!usual_.settled || (options_.habits != nullptr && !sizes_known_)) return;
  JumpSizes all = known_sizes_;
  if (options_.habits == nullptr) {
    all.add(gone_);
    all.add(tail_);
  }
  const double least = kTail * usual_.roughness.cwiseQuotient(usual_.noise).maxCoeff();
  const double most = 2.0 * usual_.extreme.cwiseQuotient(usual_.noise).maxCoeff();
  end_of_tail_ = std::min(kFarthestOutlier, all.end_of_tail(least, most));
}

bool SensorGate::away(const RepeatedReading& unit, const Neighbours& sides, bool in_a_row,
                      Judged& why) const {
  const Vector3 jump = (unit.v - sides.middle).cwiseAbs();
  double largest = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double around = std::max(sides.spread[axis], lately_[axis]);
    if (jump[axis] > std::max({farthest(axis), kJumpToSpread * around, largest})) {
      why.axis = axis;
      largest = jump[axis];
    }
  }
  if (largest == 0.0) return false;
  why.neighbours = sides.middle[why.axis];
  const double reach = kTimesLargest[std::size_t(options_.sensor)] * usual_.largest;
  const double most =
      options_.sensor == Sensor::kAcc ? std::max(kGravities * usual_.length, reach) : reach;
  if (largest > most) return true;
  if (in_a_row) return false;
  const bool field = options_.sensor == Sensor::kMag;
  if (!sides.both() && !field) return false;
  // A blow leaves a tail. A jump without a tail, or of a kind that recurs, is no blow.
  if (sides.both() && (field || jumps_recur())) {
    if (largest <= kJumpToSpread * sides.spread.maxCoeff()) return false;
  } else if (largest <= kBlowToTail * sides.spread.cwiseMax(sides.bend).maxCoeff()) {
    return false;
  }
  return !is_a_turn(unit, sides);
}

// A hand does not turn for one sample only; but a slow sensor may have just one sample of a turn.
bool SensorGate::is_a_turn(const RepeatedReading& unit, const Neighbours& sides) const {
  if (options_.sensor != Sensor::kGyr || !options_.turned_by || !sides.both()) return false;
  return options_.turned_by(unit.begin_s, units_[1].begin_s, unit.v - sides.middle);
}

bool SensorGate::jumps_recur() const { return jumps_seen_ >= kRecurs; }

// A row of zeros is no measurement of gravity or of the Earth's field; a rate may well be 0, unless
// that is a jump.
bool SensorGate::reads_zero(const RepeatedReading& unit) const {
  if (!unit.v.isZero(0.0)) return false;
  if (options_.sensor != Sensor::kGyr) return true;
  if (kept_.empty() || !usual_.settled) return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(kept_.back().v[axis]) > kZeroJump * usual_.roughness[axis]) return true;
  }
  return false;
}

bool SensorGate::is_sentinel(const RepeatedReading& unit, Judged& why) const {
  if (kept_.empty()) return false;
  const Vector3& before = kept_.back().v;
  const std::optional<int> axis = recurring_.sentinel_axis(unit.v, before, usual_);
  if (!axis) return false;
  why.axis = *axis;
  why.neighbours = before[*axis];
  return true;
}

// Whether it jumped to a value to which no reading had jumped before.
bool SensorGate::count_jump(const RepeatedReading& unit, const Neighbours& sides) {
  if (!sides.both()) return false;
  // (Blows may be clipped at one value again and again, so they must not count.)
  const double times = options_.sensor == Sensor::kMag ? kJumpToSpread : kBlowToTail;
  return recurring_.count(unit.v, sides, usual_, times);
}

bool SensorGate::wrapped(Judged& why) {
  std::optional<double> waits_s;
  if (options_.habits == nullptr) waits_s = options_.longest_wait_s;
  const std::optional<int> axis = wrapped_.wrapped_axis(units_, usual_, waits_s);
  if (!axis) return false;
  why.axis = *axis;
  why.neighbours = kept_.empty() ? 0.0 : kept_.back().v[*axis];
  wrapped_.follow(units_.front(), usual_);
  return true;
}

// Whether a reading is at the limit of the range; of a magnetometer also, so near that only noise
// keeps it below.
bool SensorGate::at_its_limit(const RepeatedReading& unit, Judged& why) const {
  if (options_.keep_clipped) return false;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int sign : {1, -1}) {
      const std::optional<double>& end = usual_.limit(axis, sign);
      if (!end) continue;
      const double limit = *end;
      const bool near = options_.sensor == Sensor::kMag &&
                        double(sign) * (limit - neighbours_of({kept_, units_}, 1).middle[axis]) <
                            kBelowItsLimit * usual_.noise[axis];
      if (unit.v[axis] != limit && !near) continue;
      why.axis = axis;
      why.neighbours = limit;
      return true;
    }
  }
  return false;
}

void SensorGate::keep(const RepeatedReading& unit) {
  kept_.push_back(unit);
  if (const std::size_t n = kept_.size(); n >= 3) {
    const Vector3 mean = 0.5 * (kept_[n - 1].v + kept_[n - 3].v);
    lately_ = (kForgetting * lately_).cwiseMax((kept_[n - 2].v - mean).cwiseAbs());
  }
  if (kept_.size() > kSide) kept_.pop_front();
  if (options_.habits != nullptr) return;
  for (std::size_t i = 0; i < unit.count; ++i) own_.add(unit.begin_s, unit.v);
  learnt_ += unit.count;
  if (double(learnt_) < kLookUpAfter * double(usual_.samples)) return;
  usual_.samples = learnt_;
  look_up(own_);
}

// Marks all samples of the first readings with this kind. When a sensor hangs, the first sample of
// the run was measured.
void SensorGate::decide(std::size_t units, const std::string& kind, const Judged& why) {
  const long end = first_unit_ + long(units);
  bool measured = kind == "stuck";
  for (Waiting& waiting : waiting_) {
    if (waiting.unit < 0) continue;
    if (waiting.unit >= end) break;
    waiting.unit = -1;
    if (std::exchange(measured, false)) continue;
    waiting.sample.kind = kind;
    waiting.sample.axis = why.axis;
    waiting.sample.neighbours = why.neighbours;
  }
  for (std::size_t i = 0; i < units; ++i) units_.pop_front();
}

void SensorGate::hand_over() {
  for (; !waiting_.empty() && waiting_.front().unit < 0; waiting_.pop_front()) {
    done_.push_back(std::move(waiting_.front().sample));
  }
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
#include "recording/checks/sensor_gate.h"

#include <algorithm>
#include <cmath>

#include "recording/checks/local_course.h"

namespace magimu {
namespace {

using Sensor = SensorGate::Sensor;

// No converter counts further than 32 bits, whatever the unit.
constexpr double kBeyondAnyRange = 4294967296.0;

constexpr std::size_t kSide = 4, kLongestRun = 3;  // readings on either side; of a jump

// An isolated jump, in standard deviations of the noise. Outliers that are noise have up to 30
// times the usual standard deviation; the largest of 1e7 normal numbers is 5.3 of theirs, 160 in
// all. Where jumps of more than that recur, smaller ones are of their kind.
constexpr double kFarthestOutlier = 200.0;
// How far the tail of this sensor's noise reaches is found from readings beyond what a normal
// distribution gives once in 1e9 (jump_sizes.h). Without a tail kSomeJump is enough. In standard
// deviations, and in spreads of neighbours.
constexpr double kTail = 6.0, kTailToSpread = 2.0;
constexpr double kSideGap = 4.0;     // times the shortest step: what is beyond is no neighbour
constexpr double kForgetting = 0.8;  // from one reading to the next: some five are remembered
// Against what the neighbours differ by, on any axis. The device's inertia and each sensor's filter
// give a blow a tail, a twentieth of it two samples later. The magnetic field knows no blows.
constexpr double kBlowToTail = 20.0, kJumpToSpread = 5.0;
// Nearer to others, or some in a row: only what no blow gives. Parts reach 16 g, one end of the
// range to the other is 32; no hand changes a rate by ten times the fastest, or the field by three
// times the strongest, for one sample.
constexpr double kGravities = 32.0, kTimesLargest[] = {3.0, 10.0, 3.0};

constexpr double kSomeJump = 10.0;           // standard deviations: counted, to see what recurs
constexpr std::size_t kRecurs = 5;           // times
constexpr double kMostJumps = 0.5;           // of the axis's jumps go to a value that means nothing
constexpr std::size_t kDifferentJumps = 64;  // remembered

constexpr double kZeroJump = 20.0;  // standard deviations, of a gyroscope that reads 0 in motion

// A run of equal readings that chance makes once in 1e6, of readings that each repeat with the
// probability that the sensor shows; and the jump at its end, in usual changes.
constexpr double kLogChanceOfRun = -13.8, kJumpAfterHanging = 5.0;
constexpr std::size_t kShortestRun = 4;
constexpr double kSomeSteps = 5.0;  // of the converter: what shows that it should have changed

// Wrapped readings: usual steps from one reading to the next that either side of the jump is from
// the end of the range, and that the jump is longer than.
constexpr double kSteps = 6.0, kWrapToStep = 10.0;

constexpr double kAbsurd = 1000.0;     // times the largest reading, isolated or not
constexpr double kLookUpAfter = 1.05;  // of the samples of which the habits were looked up

constexpr double kBelowItsLimit = 4.0;  // standard deviations: noise kept what is left there

// Readings around some others.
struct Neighbours {
  std::array<const Vector3*, kMostNeighbours> v{};
  std::array<double, kMostNeighbours> t{};
  std::size_t n = 0;
  double usual_s = 0.0;  // from one to the next

  // False: it lies beyond a gap.
  bool add(const Vector3& reading, double at, double from, double now) {
    if (std::abs(at - from) > kSideGap * usual_s) return false;
    v[n] = &reading;
    t[n++] = at - now;
    return true;
  }
  // Of each of them against the two beside it.
  Vector3 largest_bend(std::size_t first) const {
    Vector3 out = Vector3::Zero();
    for (std::size_t i = first + 1; i + 1 < n; ++i) {
      out = out.cwiseMax((*v[i] - 0.5 * (*v[i - 1] + *v[i + 1])).cwiseAbs());
    }
    return out;
  }
};

int index_of(Sensor sensor) { return sensor == Sensor::kAcc ? 0 : sensor == Sensor::kGyr ? 1 : 2; }

}  // namespace

SensorGate::SensorGate(const Options& options) : options_(options) {
  if (options_.habits != nullptr) look_up(*options_.habits);
}

void SensorGate::begin_with(const SensorHabits& habits) {
  look_up(habits);
  usual_.samples = habits.samples();
}

void SensorGate::look_up(const SensorHabits& habits) {
  usual_.settled = habits.settled();
  usual_.length = habits.usual_length();
  usual_.largest = std::max(habits.largest_length(), options_.largest_at_least);
  usual_.repeats = habits.repeats();
  usual_.same_noise = habits.same_noise();
  usual_.lively = habits.lively(0) || habits.lively(1) || habits.lively(2);
  for (int axis = 0; axis < 3; ++axis) {
    usual_.roughness[axis] = habits.roughness(axis);
    usual_.noise[axis] = habits.noise(axis);
    usual_.extreme[axis] = habits.extreme(axis);
    usual_.step[axis] = habits.step(axis);
    for (const int sign : {1, -1}) {
      auto& limit = usual_.limits[std::size_t(2 * axis + (sign > 0 ? 0 : 1))];
      limit.reset();
      if (habits.clipped(axis, sign)) limit = habits.limit(axis, sign);
    }
  }
  find_end_of_tail();
}

void SensorGate::know(const Known& known) {
  known_ = known.sentinels;
  turns_over_ = known.first_turns;
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
  Unit& unit = units_.back();
  ++unit.count;
  unit.end_s = t;
  next.unit = first_unit_ + long(units_.size()) - 1;
  waiting_.push_back(next);
}

void SensorGate::finish() {
  drain(true);
  hand_over();
}

// Judges what has enough after it.
void SensorGate::drain(bool to_the_end) {
  // The last unit may still grow.
  while (units_.size() > kSide + kLongestRun || (to_the_end && !units_.empty())) {
    first_unit_ += long(judge_front());
  }
  hand_over();
}

std::size_t SensorGate::judge_front() {
  const Unit& front = units_.front();
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
    if (wrapped(front, why)) return judged(1, "wrap");
    if (hung() || turned_while_still() || frozen()) {
      keep({front.v, front.begin_s, front.begin_s, 1});
      return judged(1, "stuck");
    }
    if (at_its_limit(front, why)) {
      follow(front);
      return judged(1, "clipped");
    }
  }
  follow(front);
  keep(front);
  return judged(1, "");
}

// How many of the first units, each of them an isolated jump; 0: the first one is none.
std::size_t SensorGate::jumped(Judged& why) {
  if (!kept_.empty() && units_.size() > 1) {  // nearly all are near their neighbours
    const Vector3 mean = 0.5 * (kept_.back().v + units_[1].v);
    const Vector3 bend = (units_.front().v - mean).cwiseAbs();
    if ((bend.array() <= 0.5 * kSomeJump * usual_.roughness.array()).all()) return 0;
  }
  const Sides sides = sides_of(1);
  const bool new_value = count_jumps(units_.front(), sides);
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
    const Sides around = sides_of(run);
    bool all = true;
    for (std::size_t i = run; i-- > 0 && all;) all = away(units_[i], around, true, why);
    if (all) return run;
  }
  return 0;
}

// What stands around the first `run` units. A hand moves on meanwhile; what lies beyond a gap says
// nothing. On one side alone there is no course: how far apart they are has the motion in it.
SensorGate::Sides SensorGate::sides_of(std::size_t run) const {
  const std::size_t before = std::min(kSide, kept_.size());
  const std::size_t after = std::min(kSide, units_.size() - run);
  const double now = 0.5 * (units_.front().begin_s + units_[run - 1].begin_s);
  Neighbours around;
  around.usual_s = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < before; ++i) {
    around.usual_s = std::min(
        around.usual_s, kept_[kept_.size() - i].begin_s - kept_[kept_.size() - i - 1].begin_s);
  }
  for (std::size_t i = 1; i < after; ++i) {
    around.usual_s =
        std::min(around.usual_s, units_[run + i].begin_s - units_[run + i - 1].begin_s);
  }
  Sides out{Vector3::Zero(), Vector3::Constant(std::numeric_limits<double>::infinity()),
            Vector3::Zero(), false, false};
  double from = units_.front().begin_s;
  for (std::size_t i = 0; i < before; ++i) {
    const Unit& unit = kept_[kept_.size() - 1 - i];
    if (!around.add(unit.v, unit.begin_s, from, now)) break;
    out.before = i > 0;
    from = unit.begin_s;
  }
  out.bend = around.largest_bend(0);
  const std::size_t n_before = around.n;
  from = units_[run - 1].begin_s;
  for (std::size_t i = 0; i < after; ++i) {
    const Unit& unit = units_[run + i];
    if (!around.add(unit.v, unit.begin_s, from, now)) break;
    out.after = i > 0;
    from = unit.begin_s;
  }
  out.bend = out.bend.cwiseMax(around.largest_bend(n_before));
  if (around.n < kSide) return out;
  if (out.both()) {
    const LocalCourse course =
        local_course({around.t.data(), around.n}, {around.v.data(), around.n});
    out.middle = course.middle;
    out.spread = course.spread;
    return out;
  }
  for (int axis = 0; axis < 3; ++axis) {
    std::array<double, kMostNeighbours> x{};
    for (std::size_t i = 0; i < around.n; ++i) x[i] = (*around.v[i])[axis];
    std::sort(x.begin(), x.begin() + std::ptrdiff_t(around.n));
    out.middle[axis] = 0.5 * (x[(around.n - 1) / 2] + x[around.n / 2]);
    out.spread[axis] = std::min(x[around.n - 1] - x[1], x[around.n - 2] - x[0]);
  }
  return out;
}

// From where on an isolated jump is no measurement.
double SensorGate::farthest(int axis) const {
  const double some = kSomeJump * usual_.roughness[axis];
  return jumps_recur() ? some : std::max(some, end_of_tail_ * usual_.noise[axis]);
}

// In standard deviations of the noise; 0 where it may be motion.
double SensorGate::size_of_jump(const Unit& unit, const Sides& sides) const {
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

// A file's first pass knows of no sizes, and a stream of those so far.
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

bool SensorGate::away(const Unit& unit, const Sides& sides, bool in_a_row, Judged& why) const {
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
  const double reach = kTimesLargest[index_of(options_.sensor)] * usual_.largest;
  const double most =
      options_.sensor == Sensor::kAcc ? std::max(kGravities * usual_.length, reach) : reach;
  if (largest > most) return true;
  if (in_a_row) return false;
  const bool field = options_.sensor == Sensor::kMag;
  if (!sides.both() && !field) return false;
  // A blow leaves a tail; whoever has none, or is of a kind that recurs, is no blow.
  if (sides.both() && (field || jumps_recur())) {
    if (largest <= kJumpToSpread * sides.spread.maxCoeff()) return false;
  } else if (largest <= kBlowToTail * sides.spread.cwiseMax(sides.bend).maxCoeff()) {
    return false;
  }
  return !is_a_turn(unit, sides);
}

// A hand does not turn for one sample alone, but a slow sensor may have no other.
bool SensorGate::is_a_turn(const Unit& unit, const Sides& sides) const {
  if (options_.sensor != Sensor::kGyr || !options_.turned_by || !sides.both()) return false;
  return options_.turned_by(unit.begin_s, units_[1].begin_s, unit.v - sides.middle);
}

bool SensorGate::jumps_recur() const { return jumps_seen_ >= kRecurs; }

// A row of zeros is no measurement of gravity or of the Earth's field; a rate may well be 0, unless
// that is a jump.
bool SensorGate::reads_zero(const Unit& unit) const {
  if (!unit.v.isZero(0.0)) return false;
  if (options_.sensor != Sensor::kGyr) return true;
  if (kept_.empty() || !usual_.settled) return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(kept_.back().v[axis]) > kZeroJump * usual_.roughness[axis]) return true;
  }
  return false;
}

bool SensorGate::is_sentinel(const Unit& unit, Judged& why) const {
  if (kept_.empty()) return false;
  const Sentinels values = sentinels();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::ranges::find(values[std::size_t(axis)], unit.v[axis]) ==
        values[std::size_t(axis)].end()) {
      continue;
    }
    why.axis = axis;
    why.neighbours = kept_.back().v[axis];
    // A reading may be the same by chance.
    if (std::abs(unit.v[axis] - why.neighbours) > kSomeJump * usual_.roughness[axis]) return true;
  }
  return false;
}

// Whether it jumped to where no reading had jumped to before.
bool SensorGate::count_jumps(const Unit& unit, const Sides& sides) {
  if (!sides.both()) return false;
  // Blows may be clipped, again and again.
  const double times = options_.sensor == Sensor::kMag ? kJumpToSpread : kBlowToTail;
  bool new_value = true;
  for (int axis = 0; axis < 3; ++axis) {
    const double jump = std::abs(unit.v[axis] - sides.middle[axis]);
    const double usual = kSomeJump * usual_.roughness[axis];
    if (!(jump > std::max(usual, times * sides.spread[axis]))) continue;
    auto& jumps = jumps_[std::size_t(axis)];
    const auto at = std::ranges::find(jumps, unit.v[axis], &Jump::value);
    if (at != jumps.end()) {
      ++at->count;
      new_value = false;
    } else if (jumps.size() < kDifferentJumps) {
      jumps.push_back({unit.v[axis], 1});
    }
  }
  return new_value;
}

SensorGate::Sentinels SensorGate::sentinels() const {
  Sentinels out = known_;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::size_t all = 0;
    for (const Jump& jump : jumps_[axis]) all += jump.count;
    for (const Jump& jump : jumps_[axis]) {
      if (jump.count >= kRecurs && double(jump.count) > kMostJumps * double(all)) {
        out[axis].push_back(jump.value);
      }
    }
  }
  return out;
}

// A stream sees the jump first: what is back at once was a blow.
bool SensorGate::goes_on_from_there(int axis, double most) const {
  if (options_.habits != nullptr) return true;
  if (units_.size() <= kSide) return false;
  for (std::size_t i = 1; i <= kSide; ++i) {
    if (std::abs(units_[i].v[axis] - units_[i - 1].v[axis]) > most) return false;
  }
  return true;
}

// From one end of the range to the other and on in the same direction: the converter or a 16-bit
// variable turned over, until it turns back.
bool SensorGate::wrapped(const Unit& unit, Judged& why) {
  // Across a gap a reading may go from any end of the range to the other.
  if (path_.size() == kSide) {
    const double interval = (path_s_.back() - path_s_.front()) / double(kSide - 1);
    if (unit.begin_s - path_s_.back() > double(kSide) * interval) {
      path_.clear();
      path_s_.clear();
    }
  }
  for (int axis = 0; axis < 3 && path_.size() == kSide; ++axis) {
    double step = usual_.roughness[axis];
    for (std::size_t i = 1; i < path_.size(); ++i) {
      step = std::max(step, std::abs(path_[i][axis] - path_[i - 1][axis]));
    }
    const double a = last_[axis], b = unit.v[axis], range = usual_.extreme[axis];
    const double nearer = std::min(std::abs(a), std::abs(b));
    const double farther = std::max(std::abs(a), std::abs(b));
    if (a * b < 0.0 && std::abs(b - a) > kWrapToStep * step && nearer > range - kSteps * step &&
        farther < range + kSteps * step && goes_on_from_there(axis, kSteps * step)) {
      turns_over_[std::size_t(axis)] += b < a ? 1 : -1;
    } else if (const int turns = turns_over_[std::size_t(axis)];
               turns != 0 && a * b < 0.0 && (b < a) == (turns < 0) && std::abs(b - a) > range) {
      turns_over_[std::size_t(axis)] += b < a ? 1 : -1;  // what came was garbage
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    turns_seen_[axis][turns_over_[axis]] += unit.count;
  }
  // A stream cannot look back: what lasts longer than it may wait is where the sensor is.
  const bool any = std::ranges::any_of(turns_over_, [](int turns) { return turns != 0; });
  if (!any) {
    right_s_ = unit.end_s;
  } else if (options_.habits == nullptr && unit.end_s - right_s_ > options_.longest_wait_s) {
    turns_over_ = {0, 0, 0};
    path_.clear();
    path_s_.clear();
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (turns_over_[std::size_t(axis)] == 0) continue;
    why.axis = axis;
    why.neighbours = kept_.empty() ? 0.0 : kept_.back().v[axis];
    follow(unit);
    return true;
  }
  return false;
}

std::array<int, 3> SensorGate::usual_turns() const {
  std::array<int, 3> out = {0, 0, 0};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto most =
        std::ranges::max_element(turns_seen_[axis], {}, [](const auto& x) { return x.second; });
    if (most != turns_seen_[axis].end()) out[axis] = most->first;
  }
  return out;
}

void SensorGate::follow(const Unit& unit) {
  last_ = unit.v;
  Vector3 whole = unit.v;
  for (int axis = 0; axis < 3; ++axis) {
    whole[axis] += 2.0 * usual_.extreme[axis] * turns_over_[std::size_t(axis)];
  }
  path_.push_back(whole);
  path_s_.push_back(unit.begin_s);
  if (path_.size() <= kSide) return;
  path_.pop_front();
  path_s_.pop_front();
}

// Readings that each repeat with the chance that this sensor shows.
bool SensorGate::longer_than_chance(const Unit& unit) const {
  if (unit.count < kShortestRun) return false;
  return double(unit.count - 1) * std::log(usual_.repeats) < kLogChanceOfRun;
}

// Whether what follows the first unit lies much further from it than readings usually change.
bool SensorGate::resumes_elsewhere(const Vector3& usual_change) const {
  const Vector3 jump = (units_[1].v - units_.front().v).cwiseAbs();
  for (int axis = 0; axis < 3; ++axis) {
    if (jump[axis] > std::max({kJumpAfterHanging * usual_change[axis],
                               kSomeJump * usual_.noise[axis], kSomeSteps * usual_.step[axis]})) {
      return true;
    }
  }
  return false;
}

// The first unit is longer than chance makes it where this sensor is as lively as before and after,
// and ends with a jump to where the sensor would have gone meanwhile.
bool SensorGate::hung() const {
  const Unit& unit = units_.front();
  if (!usual_.lively || !longer_than_chance(unit) || kept_.size() < 3 || units_.size() < 4)
    return false;
  Vector3 change = Vector3::Zero();
  std::size_t longest = 1;
  const auto look = [&](const Unit& a, const Unit& b) {
    change = change.cwiseMax((a.v - b.v).cwiseAbs());
  };
  for (std::size_t i = 1; i <= 3; ++i) {
    const Unit &before = kept_[kept_.size() - i], &after = units_[i];
    longest = std::max({longest, before.count, after.count});
    look(before, i == 1 ? unit : kept_[kept_.size() - i + 1]);
    if (i > 1) look(after, units_[i - 1]);
  }
  return unit.count >= kShortestRun * longest && resumes_elsewhere(change);
}

// A dead sensor, which is told as such.
bool SensorGate::never_changed() const { return kept_.empty() && units_.size() == 1; }

// The device turned meanwhile, and the sensor goes on elsewhere; or never.
bool SensorGate::turned_while_still() const {
  const Unit& unit = units_.front();
  if (never_changed() || !options_.turned || !longer_than_chance(unit)) return false;
  if (units_.size() > 1 && !resumes_elsewhere(Vector3::Zero())) return false;
  return options_.turned(unit.begin_s, unit.end_s);
}

// Its noise alone would have moved the sensor; other sensors still do move.
bool SensorGate::frozen() const {
  const Unit& unit = units_.front();
  if (never_changed() || !options_.others_change || !longer_than_chance(unit) ||
      double(unit.count - 1) * std::log(usual_.same_noise) > kLogChanceOfRun) {
    return false;
  }
  std::size_t longest = 1;
  for (const Unit& before : kept_) longest = std::max(longest, before.count);
  for (std::size_t i = 1; i < units_.size(); ++i) longest = std::max(longest, units_[i].count);
  return unit.count >= kShortestRun * longest && options_.others_change(unit.begin_s, unit.end_s);
}

// At the limit, or so near it that noise alone keeps a magnetometer's reading below.
bool SensorGate::at_its_limit(const Unit& unit, Judged& why) const {
  if (options_.keep_clipped) return false;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int sign : {1, -1}) {
      const auto& end = usual_.limits[std::size_t(2 * axis + (sign > 0 ? 0 : 1))];
      if (!end) continue;
      const double limit = *end;
      const bool near =
          options_.sensor == Sensor::kMag &&
          double(sign) * (limit - sides_of(1).middle[axis]) < kBelowItsLimit * usual_.noise[axis];
      if (unit.v[axis] != limit && !near) continue;
      why.axis = axis;
      why.neighbours = limit;
      return true;
    }
  }
  return false;
}

void SensorGate::keep(const Unit& unit) {
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

// All samples of the first units are of this kind; but the first that a sensor repeats was
// measured.
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

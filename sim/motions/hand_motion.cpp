// SPDX-License-Identifier: BSD-3-Clause
// The turns of a hand, drawn from a seed and evaluated at any time: hand_motion.h.
#include "sim/motions/hand_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "factors/sensor_model.h"
#include "sim/draws/random.h"

namespace magimu {
namespace {

constexpr double kKnotInterval = 0.4;            // s, the least
constexpr double kSlowest = 0.3;                 // rad/s, of a coefficient
constexpr double kWobble = 0.15;                 // rad/s, standard deviation of a component
constexpr double kAxisTilt = 0.3;                // standard deviation, against an axis of length 1
constexpr double kLargestTilt = 10.0 * kDegree;  // at the start, from level
constexpr double kSlowestPace = 0.3, kFastestPace = 1.2;
constexpr int kOpeningTurns = 6;  // these are fast and short

// The turns one after the other; coefficient by coefficient.
class Turns {
 public:
  explicit Turns(RandomStream& random) : random_(random) {}

  void begin() {
    if (drawn_ % 3 == 0) shuffle_axes();
    const int axis = axes_[drawn_ % 3];
    // The second three of six turn back what the first three turned.
    const bool second_half = drawn_ % 6 >= 3;
    if (!second_half) sign_[axis] = random_.index(2) == 0 ? 1.0 : -1.0;
    Vector3 direction = kAxisTilt * random_.normal3();
    direction[axis] = second_half ? -sign_[axis] : sign_[axis];
    const bool opening = drawn_ < kOpeningTurns;
    const double speed = random_.uniform(opening ? 1.2 : 0.5, 2.3);
    rate_ = speed * direction.normalized();
    left_ = opening ? 5 + random_.index(2) : 5 + random_.index(5);
    ++drawn_;
  }

  Vector3 next() {
    if (left_ == 0) begin();
    --left_;
    const Vector3 c = rate_ + kWobble * random_.normal3();
    return c * (std::clamp(c.norm(), kSlowest, HandMotion::kFastest) / c.norm());
  }

 private:
  // All three axes, but not first the one that came last: turning straight back is no new view.
  void shuffle_axes() {
    const int last = axes_[2];
    std::swap(axes_[2], axes_[random_.index(3)]);
    std::swap(axes_[1], axes_[random_.index(2)]);
    if (drawn_ > 0 && axes_[0] == last) std::swap(axes_[0], axes_[1 + random_.index(2)]);
  }

  RandomStream& random_;
  std::array<int, 3> axes_{0, 1, 2};
  std::array<double, 3> sign_{};
  Vector3 rate_ = Vector3::Zero();
  int left_ = 0;   // coefficients of the present turn
  int drawn_ = 0;  // turns so far
};

std::vector<Spline> draw_schedule(RandomStream& random, double duration_s, double rest_s) {
  const double last_rest = std::min(HandMotion::kRest, 0.25 * (duration_s - rest_s));
  const auto rests =
      static_cast<std::size_t>(std::lround((duration_s - rest_s) / random.uniform(40.0, 60.0)));
  std::vector<double> rest(rests), share(rests + 1);
  double resting = rest_s + last_rest, shares = 0.0;
  for (double& s : rest) resting += s = random.uniform(2.0, 3.0);
  for (double& s : share) shares += s = random.uniform(0.85, 1.15);
  std::vector<Spline> stretches;
  double t = rest_s;
  for (std::size_t i = 0; i <= rests; ++i) {
    const double end = t + (duration_s - resting) * share[i] / shares;
    stretches.push_back({t, end, {}});
    t = end + (i < rests ? rest[i] : 0.0);
  }
  return stretches;
}

void draw_rates(Turns& turns, double pace, Spline& stretch) {
  turns.begin();
  for (int j = Spline::room(stretch.end - stretch.start, kKnotInterval); j > 0; --j) {
    stretch.coefficient.push_back(pace * turns.next());
  }
}

Rot3 draw_attitude(RandomStream& random) {
  const double heading = random.uniform(0.0, 2.0 * RandomStream::kPi);
  const double direction = random.uniform(0.0, 2.0 * RandomStream::kPi);
  const double tilt = random.uniform(0.0, kLargestTilt);
  return Rot3::Exp(Vector3(0, 0, heading)) *
         Rot3::Exp(tilt * Vector3(std::cos(direction), std::sin(direction), 0));
}

}  // namespace

HandMotion::HandMotion(std::uint64_t seed, double duration_s, double rest_s, bool varied_pace) {
  RandomStream random(seed, RandomPurpose::kMotion);
  initial_nRb_ = draw_attitude(random);
  stretches_ = draw_schedule(random, duration_s, rest_s);
  const double pace =
      varied_pace ? RandomStream(seed, RandomPurpose::kPace).uniform(kSlowestPace, kFastestPace)
                  : 1.0;
  Turns turns(random);
  for (Spline& stretch : stretches_) draw_rates(turns, pace, stretch);
}

Vector3 HandMotion::at(double t, int derivative) const {
  for (const Spline& s : stretches_) {
    if (t > s.start && t < s.end) return s.at(t, derivative);
  }
  return Vector3::Zero();
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// The turns of a hand, drawn from a seed and evaluated at any time: hand_motion.h.
#include "sim/hand_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "factors/sensor_model.h"
#include "sim/random.h"

namespace magimu {
namespace {

constexpr double kKnotInterval = 0.4;            // s, the least
constexpr double kSlowest = 0.3;                 // rad/s, of a coefficient
constexpr double kWobble = 0.15;                 // rad/s, standard deviation of a component
constexpr double kAxisTilt = 0.3;                // standard deviation, against an axis of length 1
constexpr double kLargestTilt = 10.0 * kDegree;  // at the start, from level
constexpr int kOpeningTurns = 6;                 // these are fast and short

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

std::vector<HandMotion::Stretch> draw_schedule(RandomStream& random, double duration_s,
                                               double rest_s) {
  const double last_rest = std::min(HandMotion::kRest, 0.25 * (duration_s - rest_s));
  const auto rests =
      static_cast<std::size_t>(std::lround((duration_s - rest_s) / random.uniform(40.0, 60.0)));
  std::vector<double> rest(rests), share(rests + 1);
  double resting = rest_s + last_rest, shares = 0.0;
  for (double& s : rest) resting += s = random.uniform(2.0, 3.0);
  for (double& s : share) shares += s = random.uniform(0.85, 1.15);
  std::vector<HandMotion::Stretch> stretches;
  double t = rest_s;
  for (std::size_t i = 0; i <= rests; ++i) {
    const double end = t + (duration_s - resting) * share[i] / shares;
    stretches.push_back({t, end, {}});
    t = end + (i < rests ? rest[i] : 0.0);
  }
  return stretches;
}

// A spline of n coefficients spans n + 3 knot intervals and vanishes, with its first two
// derivatives, at both ends.
void draw_rates(Turns& turns, HandMotion::Stretch& stretch) {
  const int intervals = static_cast<int>((stretch.end - stretch.start) / kKnotInterval);
  turns.begin();
  for (int j = 0; j + 3 < intervals; ++j) stretch.rate.push_back(turns.next());
}

Rot3 draw_attitude(RandomStream& random) {
  const double heading = random.uniform(0.0, 2.0 * RandomStream::kPi);
  const double direction = random.uniform(0.0, 2.0 * RandomStream::kPi);
  const double tilt = random.uniform(0.0, kLargestTilt);
  return Rot3::Exp(Vector3(0, 0, heading)) *
         Rot3::Exp(tilt * Vector3(std::cos(direction), std::sin(direction), 0));
}

}  // namespace

HandMotion::HandMotion(std::uint64_t seed, double duration_s, double rest_s) {
  RandomStream random(seed, RandomPurpose::kMotion);
  initial_nRb_ = draw_attitude(random);
  stretches_ = draw_schedule(random, duration_s, rest_s);
  Turns turns(random);
  for (Stretch& stretch : stretches_) draw_rates(turns, stretch);
}

Vector3 HandMotion::omega(double t) const {
  for (const Stretch& s : stretches_) {
    if (t <= s.start || t >= s.end || s.rate.empty()) continue;
    const int count = static_cast<int>(s.rate.size());
    const double x = (t - s.start) / (s.end - s.start) * (count + 3);  // in knot intervals
    const int knot = std::min(static_cast<int>(x), count + 2);
    const double u = x - knot, v = 1.0 - u;
    // The four cubic B-splines that reach into this interval; they add up to 1.
    const std::array<double, 4> weight{v * v * v / 6.0, (4.0 - 3.0 * u * u * (2.0 - u)) / 6.0,
                                       (4.0 - 3.0 * v * v * (2.0 - v)) / 6.0, u * u * u / 6.0};
    Vector3 rate = Vector3::Zero();
    for (int i = 0; i < 4; ++i) {
      const int j = knot - 3 + i;
      if (j >= 0 && j < count) rate += weight[i] * s.rate[j];
    }
    return rate;
  }
  return Vector3::Zero();
}

}  // namespace magimu

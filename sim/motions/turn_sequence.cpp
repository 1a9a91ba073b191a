// SPDX-License-Identifier: BSD-3-Clause
#include "sim/motions/turn_sequence.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "factors/sensor_model.h"
#include "sim/draws/random.h"

namespace magimu {
namespace {

constexpr double kTurnPace = 1.0;               // rad/s, mean
constexpr double kPause = 0.5;                  // s, after each turn
constexpr double kTurnTilt = 3.0 * kDegree;     // standard deviations: of an axis,
constexpr double kTurnAngleError = 0.03;        // of an angle, as a part of it,
constexpr double kStartTilt = 2.0 * kDegree;    // and of the attitude at the start
constexpr double kTypicalDip = 60.0 * kDegree;  // of the field whose passes are counted
constexpr int kPassSteps = 12;                  // places looked at along a half turn

// Yaw, pitch, roll, and the six diagonals.
const std::array<Vector3, 9>& turn_axes() {
  static const std::array<Vector3, 9> axes{Vector3(0, 0, 1),  Vector3(0, 1, 0),  Vector3(1, 0, 0),
                                           Vector3(1, 1, 0),  Vector3(1, 0, 1),  Vector3(0, 1, 1),
                                           Vector3(1, -1, 0), Vector3(1, 0, -1), Vector3(0, 1, -1)};
  return axes;
}

// Where gravity and the field have been in the body's frame.
class Views {
 public:
  void add(const Rot3& nRb) { seen_.push_back(of(nRb)); }
  // Squared distance to the nearest of them, of both directions together.
  double distance(const Rot3& nRb) const {
    const View now = of(nRb);
    double nearest = 8.0;
    for (const View& s : seen_) {
      nearest =
          std::min(nearest, (now.up - s.up).squaredNorm() + (now.field - s.field).squaredNorm());
    }
    return nearest;
  }

 private:
  struct View {
    Vector3 up, field;
  };
  static View of(const Rot3& nRb) {
    return {nRb.unrotate(Vector3::UnitZ()), nRb.unrotate(unit_field(kTypicalDip))};
  }
  std::vector<View> seen_;
};

Rot3 part_of_turn(const Vector3& axis, int step) {
  return Rot3::Exp(RandomStream::kPi * step / kPassSteps * axis);
}

// How far the half turn's pass is from all before, on average.
double news(const Views& views, const Rot3& nRb, const Vector3& axis) {
  double sum = 0.0;
  for (int i = 1; i <= kPassSteps; ++i) sum += views.distance(nRb * part_of_turn(axis, i));
  return sum;
}

}  // namespace

TurnSequence::TurnSequence(std::uint64_t seed, double duration_s, double rest_s) {
  RandomStream random(seed, RandomPurpose::kMotion);
  initial_nRb_ = Rot3::Exp(kStartTilt * random.normal3());
  Rot3 nRb;  // as if the hand were exact: the plan is one for all seeds
  Views views;
  views.add(nRb);
  for (double t = rest_s; t < duration_s;) {
    const auto& axes = turn_axes();
    const Vector3* next = &axes[turns_.size() % axes.size()];
    if (turns_.size() >= 3) {
      next = &*std::ranges::max_element(
          axes, {}, [&](const Vector3& axis) { return news(views, nRb, axis.normalized()); });
    }
    const Vector3 axis = next->normalized();
    for (int i = 1; i <= kPassSteps; ++i) views.add(nRb * part_of_turn(axis, i));
    nRb = nRb * part_of_turn(axis, kPassSteps);

    const double angle = RandomStream::kPi * (1.0 + kTurnAngleError * random.normal());
    const Vector3 real = (axis + kTurnTilt * random.normal3()).normalized();
    turns_.push_back({t, angle / kTurnPace, kTurnPace * real});
    t += angle / kTurnPace + kPause;
  }
}

Vector3 TurnSequence::at(double t, bool derivative) const {
  const auto after = std::ranges::upper_bound(turns_, t, {}, &Turn::start);
  if (after == turns_.begin()) return Vector3::Zero();
  const Turn& turn = *(after - 1);
  const double x = (t - turn.start) / turn.length, angle = 2.0 * RandomStream::kPi * x;
  if (x >= 1.0) return Vector3::Zero();
  if (derivative) {
    return 2.0 * RandomStream::kPi / turn.length * std::sin(angle) * turn.mean_rate;
  }
  return (1.0 - std::cos(angle)) * turn.mean_rate;
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/motions/travelled_path.h"

#include <cmath>
#include <numbers>

#include "sim/draws/random.h"

namespace magimu {
namespace {

constexpr double kShortestPeriod = 8.0;  // s
constexpr double kClimb = 0.1;           // vertical velocity over that along a horizontal axis
constexpr double kSizeStep = 0.05;       // s, between the times at which the speed is measured

// derivative 0: the integral of cos k s over s from 0; 1: cos k s; 2: its derivative by s.
double wave(int k, double s, int derivative) {
  if (derivative == 0) return k == 0 ? s : std::sin(k * s) / k;
  return derivative == 1 ? std::cos(k * s) : -k * std::sin(k * s);
}

}  // namespace

Vector3 TravelledPath::Leg::at(double t, int derivative) const {
  const double rate = std::numbers::pi / (end - start), s = rate * (t - start);
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = 0; k < coefficient.size(); ++k) {
    sum += (wave(int(k), s, derivative) - wave(int(k) + 2, s, derivative)) * coefficient[k];
  }
  return sum * std::pow(rate, derivative - 1);
}

TravelledPath::TravelledPath(std::uint64_t seed, const std::vector<Spline>& stretches,
                             double rms_mps) {
  RandomStream random(seed, RandomPurpose::kTravel);
  double squares = 0.0, seconds = 0.0;
  for (const Spline& stretch : stretches) {
    Leg leg{stretch.start, stretch.end, {}};
    const double length = stretch.end - stretch.start;
    for (int k = 0; k == 0 || 2.0 * length / (k + 2) > kShortestPeriod; ++k) {
      leg.coefficient.push_back(random.normal3().cwiseProduct(Vector3(1.0, 1.0, kClimb)));
    }
    for (double t = leg.start; t < leg.end; t += kSizeStep) {
      squares += leg.at(t, 1).squaredNorm() * kSizeStep;
      seconds += kSizeStep;
    }
    legs_.push_back(std::move(leg));
  }
  if (!(squares > 0.0)) return;
  Vector3 here = Vector3::Zero();
  for (Leg& leg : legs_) {
    for (Vector3& c : leg.coefficient) c *= rms_mps / std::sqrt(squares / seconds);
    leg.from = here;
    here += leg.at(leg.end, 0);
  }
}

Vector3 TravelledPath::at(double t, int derivative) const {
  Vector3 out = Vector3::Zero();  // velocity and acceleration between two legs
  for (const Leg& leg : legs_) {
    if (t <= leg.start) break;
    const bool moves = t < leg.end;
    if (derivative == 0) out = leg.from + leg.at(moves ? t : leg.end, 0);
    if (derivative > 0) out = moves ? leg.at(t, derivative) : Vector3::Zero().eval();
  }
  return out;
}

}  // namespace magimu

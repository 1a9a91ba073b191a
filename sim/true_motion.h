// SPDX-License-Identifier: BSD-3-Clause
// The motion of a simulation at any time, true to its seed: attitude, rate, place and their
// derivatives. Times are true seconds; sample k is at k / rate_hz().
//
// The paper's motion has one rate from a sample to the next. At a sample its rate is the mean of
// those before and after, and its derivative their difference by the interval: as from one
// interval's middle to the next one's. Before the start of any motion the attitude is that of the
// start.
#pragma once

#include <optional>

#include "sim/motions/followed_motion.h"
#include "sim/motions/hand_displacement.h"
#include "sim/motions/hand_motion.h"
#include "sim/motions/motion.h"
#include "sim/motions/travelled_path.h"
#include "sim/motions/turn_sequence.h"
#include "sim/simulate.h"

namespace magimu {

class TrueMotion {
 public:
  // clock: true seconds in a second of the file.
  TrueMotion(const SimulationOptions& options, double clock);

  double rate_hz() const { return rate_hz_; }  // true samples a second
  std::size_t samples() const { return motion_.mean_rate.size(); }
  double time(std::size_t sample) const { return static_cast<double>(sample) / rate_hz_; }
  // At the samples; of the mean rates (motion.h) the one after the sample.
  const std::vector<Rot3>& nRb() const { return nRb_; }
  const std::vector<Vector3>& mean_rate() const { return motion_.mean_rate; }

  Rot3 attitude(double t) const;       // nRb
  Vector3 omega(double t) const;       // body frame, rad/s
  Vector3 omega_rate(double t) const;  // its derivative, rad/s^2

  // In n; 0 of a sensor that only turns.
  bool moves() const { return path_.has_value() || (followed_ && followed_->moves()); }
  Vector3 position(double t) const { return place(t, 0); }
  Vector3 velocity(double t) const { return place(t, 1); }
  Vector3 acceleration(double t) const { return place(t, 2); }

 private:
  // Rates before and after t; the same but at a step of the paper's motion.
  struct Step {
    Vector3 before, after;
  };
  Step step(double t) const;

  double rate_hz_;
  // In continuous time; the paper's motion is neither.
  bool continuous() const { return hand_ || sequence_ || followed_; }
  Vector3 continuous_rate(double t) const;
  Vector3 place(double t, int derivative) const;
  std::optional<HandMotion> hand_;
  std::optional<TurnSequence> sequence_;
  std::optional<HandDisplacement> path_;
  std::optional<TravelledPath> travel_;
  std::optional<FollowedMotion> followed_;
  AngularMotion motion_;
  std::vector<Rot3> nRb_;
};

}  // namespace magimu

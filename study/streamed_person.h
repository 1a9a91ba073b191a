// SPDX-License-Identifier: BSD-3-Clause
// A simulated person who holds a sensor board while it is calibrated: does what the guidance says,
// turns it about axes at random, or as the simulated hand does that nobody has told anything
// (sim/motions/hand_motion.h). All turn at the same mean pace; readings are those of an ordinary
// part, white noise of known density and biases and distortion drawn by the seed.
#pragma once

#include <optional>
#include <random>

#include "calibration/live/guidance.h"
#include "calibration/live/stream_estimate.h"
#include "calibration/live/streaming.h"
#include "sim/draws/parameters.h"
#include "sim/motions/hand_motion.h"

namespace magimu {

class StreamedPerson {
 public:
  static constexpr double kRate = 80.0, kPace = 1.0;  // Hz, rad/s
  static constexpr NoiseDensities kOrdinary{2e-3, 2e-4, 0.06};

  // noise: of the readings, per sqrt(Hz).
  explicit StreamedPerson(std::uint64_t seed, const NoiseDensities& noise = kOrdinary)
      : random_(seed),
        noise_(noise),
        truth_(draw_parameters(seed, 1)),
        nRb_(Rot3::Exp(0.1 * normal3())) {}

  const SensorParameters& truth() const { return truth_; }

  // One sample, while the body turns at the rate, rad/s.
  template <class Body>
  bool step(const Vector3& rate, const Body& body) {
    StreamSample s;
    s.t = samples_++ / kRate;
    s.gyr = rate + truth_.gyr_bias + noise(noise_.gyr);
    s.acc =
        accelerometer_model(nRb_, truth_.acc_bias, gravity_n(kStandardGravity)) + noise(noise_.acc);
    s.mag = {
        magnetometer_model(nRb_, truth_.mag[0].distortion, truth_.mag[0].bias, truth_.dip_rad) +
        noise(noise_.mag)};
    nRb_ = (nRb_ * Rot3::Exp(rate / kRate)).normalized();
    return body(s);
  }

  // The body turns about the axis at the pace for so long (still, without an axis).
  template <class Body>
  bool turn(const Vector3& axis, double seconds, const Body& body) {
    for (int k = 0; k < int(seconds * kRate); ++k) {
      // Starts and ends gently.
      const double x = (k + 0.5) / (seconds * kRate);
      if (step(axis * (kPace * (1.0 - std::cos(2.0 * M_PI * x))), body)) return true;
    }
    return false;
  }

  // As the simulated hand, at a pace that is ours over its first twenty seconds (it begins with the
  // fastest turns), where it does not rest.
  template <class Body>
  bool turn_like(const HandMotion& hand, double seconds, const Body& body) {
    constexpr double kCompared = 20.0;
    double turned = 0.0, moving = 0.0;
    for (double t = 0.0; t < kCompared; t += 1.0 / kRate) {
      const double rate = hand.omega(t).norm();
      turned += rate;
      moving += rate > 0.0 ? 1.0 : 0.0;
    }
    const double slower = kPace * moving / turned;
    for (int k = 0; k < int(seconds * kRate); ++k) {
      if (step(slower * hand.omega(slower * k / kRate), body)) return true;
    }
    return false;
  }

  // A turn about an axis of the body drawn at random, by any angle up to the largest.
  template <class Body>
  bool turn_at_random(double largest_rad, const Body& body) {
    const double angle = largest_rad * uniform();
    return turn(normal3().normalized(), angle / kPace, body);
  }
  double sign() { return uniform() < 0.5 ? -1.0 : 1.0; }

 private:
  double uniform() { return double(random_() >> 11) * 0x1p-53; }
  double normal() {
    return std::sqrt(-2.0 * std::log(1.0 - uniform())) * std::cos(2.0 * M_PI * uniform());
  }
  Vector3 normal3() {
    const double x = normal(), y = normal(), z = normal();
    return Vector3(x, y, z);
  }
  Vector3 noise(double density) { return density * std::sqrt(kRate) * normal3(); }

  std::mt19937_64 random_;
  NoiseDensities noise_;
  SensorParameters truth_;
  Rot3 nRb_;
  long samples_ = 0;
};

// The axis of the motion that a sentence asks for, as someone understands it who reads it: "about
// its x axis", "between its x and -y axes"; zero: keep still.
inline Vector3 axis_of(const std::string& sentence) {
  const auto said = sentence.find(" its ");
  Vector3 axis = Vector3::Zero();
  if (sentence.find(" ax", said) == std::string::npos) return axis;
  for (auto at = said; at < sentence.size() && sentence.compare(at, 3, " ax") != 0; ++at) {
    const bool ends = std::string(" .").find(sentence[at + 1]) != std::string::npos;
    if (sentence[at] < 'x' || sentence[at] > 'z' || !ends) continue;
    axis[sentence[at] - 'x'] = sentence[at - 1] == '-' ? -1.0 : 1.0;
  }
  return axis.normalized();
}

// And by what angle, rad.
inline double angle_of(const std::string& sentence) {
  return sentence.find("three quarters") == std::string::npos ? M_PI : 1.5 * M_PI;
}

// What a person does.
struct Habit {
  double random_rad = 0.0;  // turns about axes at random, by up to so much at a time
  bool hand = false;        // moves like the simulated hand
};                          // else what the sentences say

struct PersonResult {
  double seconds = 600.0;                  // until the stream says that it is good enough; at most
  std::optional<Calibration> calibration;  // at that moment
  SensorParameters truth;
};

inline PersonResult turn_until_good_enough(std::uint64_t seed, const Habit& habit,
                                           const StreamingOptions& options) {
  constexpr double kStill = 3.0, kReading = 0.25;  // s; the latter for each sentence
  StreamedPerson person(seed);
  StreamingCalibration stream(1, options);
  std::string sentence;
  PersonResult out;
  out.truth = person.truth();
  const double longest = out.seconds;
  const auto feed = [&](const StreamSample& s) {
    const auto u = stream.add(s);
    if (!u) return s.t >= longest;
    sentence = u->guidance;
    if (u->phase != StreamPhase::kConverged) return s.t >= longest;
    out.seconds = s.t;
    out.calibration = u->theta;
    return true;
  };
  if (habit.hand) {
    person.turn_like(HandMotion(seed, longest, 0.0), longest, feed);
    return out;
  }
  for (;;) {
    if (habit.random_rad > 0.0) {
      if (person.turn_at_random(habit.random_rad, feed)) return out;
      continue;
    }
    if (person.turn(Vector3::Zero(), kReading, feed)) return out;
    if (sentence.empty()) continue;
    const Vector3 axis = axis_of(sentence);
    const double seconds = axis.isZero() ? kStill : angle_of(sentence) / StreamedPerson::kPace;
    if (person.turn(person.sign() * axis, seconds, feed)) return out;
  }
}

// random_rad: 0 does what the sentences say, else turns at random by up to so much at a time.
inline double time_to_target(std::uint64_t seed, double random_rad,
                             const StreamingOptions& options) {
  return turn_until_good_enough(seed, {.random_rad = random_rad}, options).seconds;
}

}  // namespace magimu

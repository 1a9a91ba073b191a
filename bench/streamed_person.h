// SPDX-License-Identifier: BSD-3-Clause
// A simulated person who holds a sensor board while it is calibrated: either does what the guidance
// says, or turns it at random. Both turn at the same pace; readings are those of an ordinary part,
// white noise of known density and biases and distortion drawn by the seed.
#pragma once

#include <random>

#include "calibration/guidance.h"
#include "calibration/stream_estimate.h"
#include "calibration/streaming.h"
#include "sim/parameters.h"

namespace magimu {

class StreamedPerson {
 public:
  static constexpr double kRate = 80.0, kPace = 1.0;  // Hz, rad/s
  static constexpr NoiseDensities kOrdinary{2e-3, 2e-4, 0.06};

  explicit StreamedPerson(std::uint64_t seed)
      : random_(seed), truth_(draw_parameters(seed, 1)), nRb_(Rot3::Exp(0.1 * normal3())) {}

  const SensorParameters& truth() const { return truth_; }

  // The body turns about the axis at the pace for so long (still, without an axis).
  template <class Body>
  bool turn(const Vector3& axis, double seconds, const Body& body) {
    for (int k = 0; k < int(seconds * kRate); ++k) {
      // Starts and ends gently.
      const double x = (k + 0.5) / (seconds * kRate);
      const Vector3 rate = axis * (kPace * (1.0 - std::cos(2.0 * M_PI * x)));
      StreamSample s;
      s.t = samples_++ / kRate;
      s.gyr = rate + truth_.gyr_bias + noise(kOrdinary.gyr);
      s.acc = accelerometer_model(nRb_, truth_.acc_bias, gravity_n(kStandardGravity)) +
              noise(kOrdinary.acc);
      s.mag = {
          magnetometer_model(nRb_, truth_.mag[0].distortion, truth_.mag[0].bias, truth_.dip_rad) +
          noise(kOrdinary.mag)};
      nRb_ = (nRb_ * Rot3::Exp(rate / kRate)).normalized();
      if (body(s)) return true;
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

// Seconds until the stream says that it is good enough; 600 at the most. random_rad: 0 does what
// the sentences say, else turns at random by up to so much at a time.
inline double time_to_target(std::uint64_t seed, double random_rad,
                             const StreamingOptions& options) {
  constexpr double kLongest = 600.0, kStill = 3.0;
  StreamedPerson person(seed);
  StreamingCalibration stream(1, options);
  std::string sentence = "Keep it still";
  double reached = kLongest;
  const auto feed = [&](const StreamSample& s) {
    const auto u = stream.add(s);
    if (!u) return s.t >= kLongest;
    sentence = u->guidance;
    if (u->phase == StreamPhase::kConverged) reached = s.t;
    return u->phase == StreamPhase::kConverged || s.t >= kLongest;
  };
  if (person.turn(Vector3::Zero(), kStill, feed)) return reached;
  for (;;) {
    if (random_rad > 0.0) {
      if (person.turn_at_random(random_rad, feed)) return reached;
      continue;
    }
    const Vector3 axis = axis_of(sentence);
    const double seconds = axis.isZero() ? kStill : M_PI / StreamedPerson::kPace;
    if (person.turn(person.sign() * axis, seconds, feed)) return reached;
  }
}

}  // namespace magimu

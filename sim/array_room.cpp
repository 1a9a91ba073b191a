// SPDX-License-Identifier: BSD-3-Clause
#include "sim/array_room.h"

#include <fmt/format.h>

#include <cmath>

#include "recording/data/error.h"
#include "sim/draws/random.h"

namespace magimu {
namespace {

constexpr double kTurn = 2.0 * RandomStream::kPi;
constexpr double kMu0Over4Pi = 0.1;         // uT m^3 / (A m^2)
const Vector3 kHalfRoom(2.5, 2.5, 1.2);     // m, about the room's middle
const Vector3 kPathMiddle(0.0, 0.0, -0.4);  // 0.8 m above the floor
const Vector3 kEarth(4.0, 16.0, -44.0);     // uT
constexpr double kRampUp = 0.5;             // s, from rest

struct Dipole {
  Vector3 place, moment;
};

std::vector<Dipole> dipoles_of(const ArrayRoomOptions& options) {
  RandomStream random(options.seed, RandomPurpose::kRoom);
  std::vector<Dipole> dipoles;
  for (int i = 0; i < options.dipoles; ++i) {
    Vector3 place = random.uniform3(-1.0, 1.0).cwiseProduct(kHalfRoom);
    const int face = random.index(6);
    place[face / 2] = face % 2 == 0 ? kHalfRoom[face / 2] : -kHalfRoom[face / 2];
    dipoles.push_back({place, options.moment * random.normal3()});
  }
  return dipoles;
}

Vector3 field_of(const std::vector<Dipole>& dipoles, const Vector3& place) {
  Vector3 field = kEarth;
  for (const Dipole& dipole : dipoles) {
    const Vector3 r = place - dipole.place;
    const double distance = r.norm();
    const Vector3 n = r / distance;
    field += kMu0Over4Pi / (distance * distance * distance) *
             (3.0 * n.dot(dipole.moment) * n - dipole.moment);
  }
  return field;
}

// Around the square: sine and cosine, each flattened at its ends, which rounds the corners.
class SquareWalk {
 public:
  explicit SquareWalk(const ArrayRoomOptions& options) : options_(options) {}

  Vector3 position(double t) const {
    // From rest to full speed within about a second.
    const double lap = (t - kRampUp * (1.0 - std::exp(-t / kRampUp))) / options_.lap_s;
    const double x = flattened(std::cos(kTurn * lap)), y = flattened(std::sin(kTurn * lap));
    const double bob = 0.02 * std::sin(kTurn * 1.8 * t);
    return kPathMiddle + Vector3(options_.side_m / 2.0 * x, options_.side_m / 2.0 * y, bob);
  }
  Rot3 attitude(double t) const {
    const double yaw = 0.5 * std::sin(kTurn * t / options_.lap_s);
    const Vector3 wobble(0.08 * std::sin(kTurn * 0.9 * t), 0.06 * std::sin(kTurn * 0.7 * t + 1.0),
                         0.0);
    return Rot3::Exp(Vector3(0.0, 0.0, yaw)) * Rot3::Exp(wobble);
  }
  // By central differences of the fourth order; their error is below 1e-6 m/s^2.
  Vector3 acceleration(double t) const {
    constexpr double kStep = 2e-3;
    const auto p = [&](int i) { return position(t + i * kStep); };
    return (-p(-2) + 16.0 * p(-1) - 30.0 * p(0) + 16.0 * p(1) - p(2)) / (12.0 * kStep * kStep);
  }

 private:
  static double flattened(double u) { return u * (1.5 - 0.5 * u * u); }
  const ArrayRoomOptions& options_;
};

void check(const ArrayRoomOptions& options) {
  if (options.positions.empty() || !(options.rate_hz >= 1.0) || !(options.duration_s > 0.0) ||
      options.duration_s * options.rate_hz > 1e7) {
    throw InputError("", 0, 0, "an array of no magnetometers, or a rate or duration out of range",
                     "give positions, at least 1 Hz, and at most 10^7 samples");
  }
}

}  // namespace

Vector3 room_field(const ArrayRoomOptions& options, const Vector3& place) {
  return field_of(dipoles_of(options), place);
}

Recording simulate_array(const ArrayRoomOptions& options) {
  check(options);
  const std::vector<Dipole> dipoles = dipoles_of(options);
  const SquareWalk walk(options);
  RandomStream acc(options.seed, RandomPurpose::kAccelerometerNoise);
  RandomStream gyr(options.seed, RandomPurpose::kGyroscopeNoise);
  std::vector<RandomStream> mag;
  for (std::size_t m = 0; m < options.positions.size(); ++m) {
    mag.emplace_back(options.seed, RandomPurpose::kMagnetometerNoise, m);
  }
  const Vector3 acc_bias = options.acc_bias * acc.normal3();
  const Vector3 gyr_bias = options.gyr_bias * gyr.normal3();
  const Vector3 g(0.0, 0.0, -options.gravity);
  const double dt = 1.0 / options.rate_hz;

  Recording out;
  out.name = fmt::format("room {}", options.seed);
  out.mag.resize(options.positions.size());
  out.mag_names = {"mag"};
  for (std::size_t m = 0; m < mag.size() && mag.size() > 1; ++m) {
    out.mag_names.resize(mag.size());
    out.mag_names[m] = fmt::format("mag{}", m + 1);
  }
  MotionTruth truth;
  const auto samples = static_cast<std::size_t>(options.duration_s * options.rate_hz);
  for (std::size_t k = 0; k < samples; ++k) {
    const double t = static_cast<double>(k) * dt;
    const Rot3 R = walk.attitude(t);
    const Vector3 p = walk.position(t);
    const Vector3 force = R.unrotate(walk.acceleration(t) - g);
    const Vector3 rate = (R.inverse() * walk.attitude(t + dt)).Log() / dt;
    out.acc.push_back(t, force + acc_bias + options.acc_noise * acc.normal3());
    out.gyr.push_back(t, rate + gyr_bias + options.gyr_noise * gyr.normal3());
    for (std::size_t m = 0; m < mag.size(); ++m) {
      const Vector3 field = field_of(dipoles, p + R * options.positions[m]);
      out.mag[m].push_back(t, R.unrotate(field) + options.mag_noise * mag[m].normal3());
    }
    truth.t.push_back(t);
    truth.nRb.push_back(R);
    truth.position.push_back(p);
    truth.valid.push_back(true);
  }
  out.truth = std::move(truth);
  return out;
}

}  // namespace magimu

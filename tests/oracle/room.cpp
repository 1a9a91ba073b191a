// SPDX-License-Identifier: BSD-3-Clause
#include "tests/oracle/room.h"

#include <cmath>
#include <numbers>

#include "tests/oracle/random.h"

namespace magimu::oracle {

using Eigen::Vector3d;

Room::Room(std::uint64_t seed, const Vector3d& earth, double duration_s) {
  Random random(seed, Stream::kRoom);
  const Vector3d half(2.4, 2.8, 1.5);
  for (int i = 0; i < 14; ++i) {
    Vector3d middle = random.uniform3(-1.0, 1.0).cwiseProduct(half);
    const int face = random.index(6);
    middle[face / 2] = (face % 2 == 0 ? 1.15 : -1.15) * half[face / 2];
    const Vector3d axis = random.direction();
    const double length = random.uniform(0.5, 1.5), strength = random.uniform(10.0, 30.0);
    charges_.push_back({middle + 0.5 * length * axis, strength});
    charges_.push_back({middle - 0.5 * length * axis, -strength});
  }
  // One after the other: compilers differ in the order of a call's arguments.
  const double east = random.uniform(-0.9, 0.1), north = random.uniform(-0.7, 0.0),
               below = random.uniform(0.5, 0.8);
  const Vector3d corner(east, north, -below);
  const double tile = random.uniform(0.2, 0.6), thick = 0.03;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 4; ++j) {
      const Vector3d at = corner + Vector3d(0.2 * i, 0.2 * j, 0.0);
      charges_.push_back({at + 0.5 * thick * earth, tile / thick});
      charges_.push_back({at - 0.5 * thick * earth, -tile / thick});
    }
  }
  const double heading = random.uniform(0.0, 2.0 * std::numbers::pi);
  const Vector3d outwards(std::cos(heading), std::sin(heading), -0.2);
  const Vector3d along(-std::sin(heading), std::cos(heading), 0.0);
  const double away = random.uniform(12.0, 22.0);
  tram_ = {{away * outwards + 7.0 * along, 120.0}, {away * outwards - 7.0 * along, -120.0}};
  tram_velocity_ = random.uniform(7.0, 13.0) * along;
  tram_s_ = duration_s * random.uniform(0.3, 0.7);
}

// mu0 / (4 pi) q r / |r|^3 of each charge.
Vector3d Room::field_uT(const Vector3d& place, double t) const {
  Vector3d sum = Vector3d::Zero();
  const auto add = [&](const Charge& c, const Vector3d& moved) {
    const Vector3d r = place - c.place - moved;
    sum += 0.1 * c.strength / std::pow(r.norm(), 3) * r;
  };
  for (const Charge& c : charges_) add(c, Vector3d::Zero());
  for (const Charge& c : tram_) add(c, (t - tram_s_) * tram_velocity_);
  return sum;
}

}  // namespace magimu::oracle

// SPDX-License-Identifier: BSD-3-Clause
#include "sim/hand_room.h"

#include "factors/effects/catalogue.h"
#include "sim/draws/random.h"

namespace magimu {
namespace {

constexpr int kInWalls = 16, kTablePieces = 4;  // pieces along each side of the table
constexpr double kPiece = 0.2;                  // m

}  // namespace

HandRoom::HandRoom(std::uint64_t seed, const Vector3& earth_n, double duration_s) {
  RandomStream random(seed, RandomPurpose::kHandRoom);
  for (int i = 0; i < kInWalls; ++i) {
    const Vector3 way = random.normal3().normalized();
    const double distance = random.uniform(2.0, 4.0);
    const double size = random.uniform(10.0, 40.0);
    const Vector3 along = random.normal3().normalized();
    dipoles_.push_back({distance * way, size * along});
  }
  const double below = random.uniform(0.5, 0.9), east = random.uniform(-0.4, 0.4),
               north = random.uniform(-0.4, 0.4), per_piece = random.uniform(0.2, 0.8);
  for (int i = 0; i < kTablePieces; ++i) {
    for (int j = 0; j < kTablePieces; ++j) {
      const double middle = 0.5 * (kTablePieces - 1);
      dipoles_.push_back(
          {Vector3(east + kPiece * (i - middle), north + kPiece * (j - middle), -below),
           per_piece * earth_n});
    }
  }
  const double heading = random.uniform(0.0, 2.0 * RandomStream::kPi);
  const double away = random.uniform(12.0, 25.0), speed = random.uniform(8.0, 14.0);
  const Vector3 towards(std::cos(heading), std::sin(heading), 0.0);
  const Vector3 size = random.normal3();
  tram_ = {away * towards - Vector3(0.0, 0.0, 3.0), 1500.0 * size};
  tram_velocity_ = speed * Vector3(-towards.y(), towards.x(), 0.0);
  tram_s_ = duration_s * random.uniform(0.3, 0.7);
}

Vector3 HandRoom::field_uT(const Vector3& place, double t) const {
  Vector3 sum = dipole_field(tram_.moment, place - tram_.place - (t - tram_s_) * tram_velocity_);
  for (const Dipole& d : dipoles_) sum += dipole_field(d.moment, place - d.place);
  return sum;
}

}  // namespace magimu

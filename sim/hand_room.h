// SPDX-License-Identifier: BSD-3-Clause
// The magnetic field of a room in which a hand moves the sensor about: iron beyond the walls, a
// steel table below, and a tram that passes outside. All of it is dipoles, so that the field is
// free of curl and divergence wherever the sensor is.
//
//   walls   16 dipoles, 2 to 4 m away in any direction, of such a size that the field differs by
//           some uT over a metre
//   table   a plate 0.5 to 0.9 m below, about beside the hand, in pieces of 0.2 m that the Earth's
//           field magnetizes (moment along it, as much for each piece)
//   tram    one large dipole that goes by at 8 to 14 m/s, 12 to 25 m away, at some time in the
//           middle of the recording
#pragma once

#include <cstdint>
#include <vector>

#include "graph/scalar.h"

namespace magimu {

class HandRoom {
 public:
  // earth_n: direction of the Earth's field, in n; duration_s: of the recording.
  HandRoom(std::uint64_t seed, const Vector3& earth_n, double duration_s);

  // What the room adds to the Earth's field, in n, uT, at a place in the frame of the hand's
  // motion.
  Vector3 field_uT(const Vector3& place, double t) const;

  struct Dipole {
    Vector3 place, moment;  // m, A m^2
  };
  const std::vector<Dipole>& dipoles() const { return dipoles_; }  // that stay where they are
  double tram_passes_s() const { return tram_s_; }

 private:
  std::vector<Dipole> dipoles_;
  Dipole tram_;
  Vector3 tram_velocity_;  // m/s
  double tram_s_ = 0.0;
};

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// A room for a sensor that a hand moves: girders in walls, floor and ceiling, a steel table, and a
// tram that passes. The field is the gradient of a scalar potential, summed over magnetic charges:
// a girder is a rod with one charge at each end, the table a sheet magnetized along the Earth's
// field whose faces are charged, the tram a rod that moves. So it is curl-free and free of
// divergence where no charge is, and computed otherwise than the product computes its dipoles.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace magimu::oracle {

class Room {
 public:
  // earth: the Earth's field, a unit vector in n; duration_s: of the recording.
  Room(std::uint64_t seed, const Eigen::Vector3d& earth, double duration_s);

  // Beyond the Earth's field, n, uT; place relative to where the motion starts, m.
  Eigen::Vector3d field_uT(const Eigen::Vector3d& place, double t) const;

 private:
  struct Charge {
    Eigen::Vector3d place;
    double strength;  // A m
  };
  std::vector<Charge> charges_, tram_;
  Eigen::Vector3d tram_velocity_;
  double tram_s_;
};

}  // namespace magimu::oracle

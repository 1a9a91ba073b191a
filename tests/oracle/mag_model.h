// SPDX-License-Identifier: BSD-3-Clause
// What the magnetometer would read without noise, with every effect of docs/effects.md that touches
// it, in three groups: what changes the field b (in n), what adds to h = D b + o_m, and what adds
// to the reading. mag_time_offset and mag_lag act on h as a whole: mag = h(t - tau), or s with
// tau s' + s = h, exactly.
#pragma once

#include <optional>

#include "tests/oracle/imu_model.h"
#include "tests/oracle/room.h"

namespace magimu::oracle {

class MagModel {
 public:
  // true_t: the instants of the samples.
  MagModel(const Options& options, const Device& device, const Motion& motion,
           const std::vector<double>& true_t);

  std::vector<Vector3d> readings() const;

 private:
  std::vector<Vector3d> h_before(double offset) const;  // h, or s, that long before the samples
  Vector3d field(const Instant& at) const;              // b = R^T (m(alpha) + ...)
  Vector3d hard_iron(const Instant& at) const;          // o_m + ...
  Vector3d h(double t) const;                           // D b + o_m
  Vector3d reading_terms(const Instant& at) const;      // eddy currents, nonlinearity, ...
  std::vector<Vector3d> lagged(const std::vector<double>& t, double lag) const;
  void add_memory(std::vector<Vector3d>& readings, double chi, double relaxation_s) const;
  void mix(std::vector<Vector3d>& readings, const Effect& second_device) const;
  void add_last_turn(std::vector<Vector3d>& readings, const Effect& effect) const;

  const Options& options_;
  const Device& device_;
  const Motion& motion_;
  std::vector<double> t_;
  std::optional<Room> room_;
  double mean_temperature_ = 0.0;
  Vector3d mean_p_ = Vector3d::Zero();
  double offset_ = 0.0;                      // mag_time_offset, s
  double lag_ = 0.0;                         // mag_lag, s
  double mean_s_ = 0.0;                      // mag_bandwidth
  Vector3d axis_offset_ = Vector3d::Zero();  // mag_axis_time_offset, s
};

// The field, uT, of a dipole `moment` (A m^2) at `from_source` (m) from it.
Vector3d dipole_field_uT(const Vector3d& moment, const Vector3d& from_source);

// The current of a motor that was started t seconds ago, as a share of its mean.
double motor_current(double t, double hz);

// tau s' + s = h over a step of x tau, h going straight from h0 to h1: exact.
Vector3d relax(const Vector3d& s, const Vector3d& h0, const Vector3d& h1, double x);

}  // namespace magimu::oracle

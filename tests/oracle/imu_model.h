// SPDX-License-Identifier: BSD-3-Clause
// What accelerometer and gyroscope would read without noise, as functions of the true time, with
// every effect of docs/effects.md that touches them: one `case` each.
#pragma once

#include <functional>

#include "tests/oracle/sensors.h"

namespace magimu::oracle {

// Everything the equations mention, at one instant of true time.
struct Instant {
  double t;
  Matrix3d bRn;    // R^T
  Vector3d omega;  // body, rad/s
  Vector3d p;      // n, m
  Vector3d f;      // specific force R^T (a - g), m/s^2
};
Instant instant(const Motion& motion, double gravity, double t);

// An effect's first nine parameters, row by row.
Matrix3d first_matrix(const Effect& effect);

// Legendre polynomial of order j at x; sum_j c_j phi_j of an effect's parameters; and x of a time:
// -1 at the recording's start, 1 at its end.
double legendre(int j, double x);
Vector3d polynomial(const Effect& effect, double x, int first = 1);
double phase(const Motion& motion, double t);

// Whether t lies in [t0, t1), which are the effect's parameters number i and i + 1.
bool lasts(const Effect& effect, int i, double t);

// The mean of f over a time of that width about t.
Vector3d mean_about(double t, double width, const std::function<Vector3d(double)>& f);

// The play operator, axis by axis: what follows, `width` behind, whatever pushes it.
void stick(std::vector<Vector3d>& readings, double width);

class ImuModel {
 public:
  // true_t: the instants of the IMU's samples and one more, where the last interval ends.
  ImuModel(const Options& options, const Device& device, const Motion& motion,
           const std::vector<double>& true_t);

  std::vector<Vector3d> acc() const;
  std::vector<Vector3d> gyr() const;
  const std::vector<Vector3d>& gyr_bias_drift() const { return drift_; }

 private:
  Vector3d acc_at(double t) const;
  Vector3d gyr_at(double t) const;
  void draw_drift(double q);
  void draw_taps(const Effect& effect);
  Vector3d drift_mean(std::size_t k) const;

  struct Tap {
    double t;
    Vector3d size;
  };

  const Options& options_;
  const Device& device_;
  const Motion& motion_;
  const std::vector<double>& t_;
  double gravity_;
  double acc_offset_ = 0.0;  // acc_time_offset, s
  double acc_mean_s_ = 0.0;  // acc_bandwidth
  double mean_temperature_ = 0.0;
  bool gyr_needs_force_ = false;
  std::vector<Vector3d> drift_;         // of the gyroscope, at t_
  std::vector<Vector3d> drift_bridge_;  // its mean over an interval beside the mean of its ends
  std::vector<Tap> taps_;
};

}  // namespace magimu::oracle

// SPDX-License-Identifier: BSD-3-Clause
#include "bench/real/orientation_filter.h"

#include <Eigen/LU>
#include <algorithm>

#include "calibration/start/attitude.h"

namespace magimu {
namespace {

// A reading turned by the gyroscope alone, to the frame of its first sample.
struct Reading {
  double t;
  bool is_mag;
  Vector3 v;
};

std::vector<Reading> turned_readings(const Recording& recording, const Corrections& c,
                                     const IntegratedRotation& gyr) {
  const SensorParameters& p = c.parameters;
  const Matrix3 inverse = p.mag.front().distortion.inverse();
  std::vector<Reading> out;
  for (std::size_t k = 0; k < recording.acc.size(); ++k) {
    const double t = recording.acc.t[k];
    out.push_back({t, false, gyr.at(t) * Vector3(recording.acc.v[k] - p.acc_bias)});
  }
  const VectorSeries& mag = recording.mag.front();
  for (std::size_t k = 0; k < mag.size(); ++k) {
    const double t = mag.t[k] - c.mag_lag_s;
    out.push_back({t, true, gyr.at(t) * Vector3(inverse * (mag.v[k] - p.mag.front().bias))});
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Reading& a, const Reading& b) { return a.t < b.t; });
  return out;
}

// The filter's state: what is to be added, from the left, to the gyroscope's own attitude. The
// gyroscope turns an attitude from the right, so between corrections this stands still, and time
// may run either way.
class Correction {
 public:
  Correction(const Rot3& start, const FilterOptions& options) : nRg_(start), options_(options) {}

  void add(const Reading& reading) {
    double& last = reading.is_mag ? last_mag_ : last_acc_;
    const double dt = std::isnan(last) ? 0.0 : std::abs(reading.t - last);
    last = reading.t;
    const Vector3 v = nRg_ * reading.v;
    Vector3 turn;
    if (reading.is_mag) {
      turn = Vector3(0.0, 0.0, std::atan2(v[0], v[1]) * gain(dt, options_.mag_time_s));
    } else {
      turn = Vector3(v[1], -v[0], 0.0) * (gain(dt, options_.acc_time_s) / kStandardGravity);
    }
    nRg_ = (Rot3::Exp(turn) * nRg_).normalized();
  }
  const Rot3& nRg() const { return nRg_; }

 private:
  static double gain(double dt, double time_s) { return 1.0 - std::exp(-dt / time_s); }

  Rot3 nRg_;
  FilterOptions options_;
  double last_acc_ = NAN, last_mag_ = NAN;
};

}  // namespace

Corrections corrections(const Calibration& calibration) {
  Corrections out;
  out.parameters = calibration.parameters;
  for (const ActiveEffect& effect : calibration.effects) {
    if (effect.name == "mag_time_offset") out.mag_lag_s = effect.parameters.front().value;
    if (effect.name != "gyro_scale_misalignment") continue;
    for (std::size_t e = 0; e < 9; ++e) {
      out.gyr_matrix[Eigen::Index(e)] = effect.parameters[e].value;
    }
  }
  return out;
}

TrajectoryEstimate track(const Recording& recording, const Corrections& c,
                         const FilterOptions& options) {
  const IntegratedRotation gyr(recording.gyr, c.parameters.gyr_bias, c.gyr_matrix);
  const std::vector<Reading> readings = turned_readings(recording, c, gyr);
  const std::vector<double> ends{recording.acc.t.front(), recording.acc.t.back()};
  const std::vector<Rot3> nRb = estimate_attitudes(recording, c.parameters, gyr, ends);

  TrajectoryEstimate out;
  out.recording = recording.name;
  Correction forward(nRb[0] * gyr.at(ends[0]).inverse(), options);
  for (const Reading& reading : readings) {
    forward.add(reading);
    if (reading.is_mag) continue;
    out.t.push_back(reading.t);
    out.nRb.push_back(forward.nRg());
  }
  Correction backward(nRb[1] * gyr.at(ends[1]).inverse(), options);
  std::size_t k = out.t.size();
  for (auto reading = readings.rbegin(); reading != readings.rend(); ++reading) {
    backward.add(*reading);
    if (reading->is_mag) continue;
    Rot3& nRg = out.nRb[--k];
    const Vector3 apart = (backward.nRg() * nRg.inverse()).Log();
    nRg = (Rot3::Exp(0.5 * apart) * nRg * gyr.at(reading->t)).normalized();
  }
  return out;
}

}  // namespace magimu

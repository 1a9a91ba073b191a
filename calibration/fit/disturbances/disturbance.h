// SPDX-License-Identifier: BSD-3-Clause
// What a fitted model lacks, as a state: an Ornstein-Uhlenbeck process of three numbers that adds
// to one sensor's readings or to the field, and how much more probable the readings are with it,
//
//   G = max over size >= 0 and memory of log p(readings | model, process) - log p(readings | model)
//
// trajectory and parameters integrated out with flat priors in both, in the same coordinates (the
// model linearized at its optimum). Both are densities of the same numbers: the means of the
// samples about the nodes, in units of their noise. Nothing but what the process adds can be
// gained: G = 0 where the model predicts the data. Whether it is in the field or in the sensor, in
// the magnetometer or in the gyroscope, shows in which process gains most.
//
// The memory has no meaning at size zero, so neither chi-square nor its half is G's law where the
// model is right. It is simulated (bench/answers/evidence.cpp): kNullGain.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calibration/fit/disturbances/field_of_place.h"
#include "calibration/fit/stage.h"
#include "calibration/motion/rests/rests.h"
#include "calibration/motion/sensor_rows.h"
#include "graph/sensor.h"
#include "solvers/chain/process_chain.h"

namespace magimu {

// Nats that one process hardly ever gains where the model predicts the data (docs/evidence.md).
inline constexpr double kNullGain = 6.0;

// Where a disturbance lives.
enum class DisturbedPart {
  kField,  // the field, navigation frame: mag = D R' (m + b / strength) + o_m, uT
  kMag,    // the (first) magnetometer, in its own frame: mag = D R' m + o_m + b, uT
  kGyr,    // the gyroscope: gyr = omega + o_w + b, rad/s
  kAcc,    // the accelerometer, m/s^2
};
inline constexpr DisturbedPart kDisturbedParts[] = {DisturbedPart::kField, DisturbedPart::kMag,
                                                    DisturbedPart::kGyr, DisturbedPart::kAcc};
Sensor sensor_of(DisturbedPart part);
std::string frame_of(DisturbedPart part);  // "navigation", "sensor", "sensor", "sensor"

struct DisturbanceFit {
  DisturbedPart part = DisturbedPart::kMag;
  double gain_nats = 0.0;             // G
  double size = 0.0, memory_s = 0.0;  // standard deviation of each number; 0: nothing is gained
  // By what the magnetometer's noise density is multiplied beside the process.
  double mag_noise = 1.0;
  // The score of size^2 at zero in its standard deviations, the largest over memories: about N(0,
  // 1) at each memory where the model predicts the data.
  double score = 0.0;
  bool fitted = false;  // false: the score shows that nothing is gained
  // Log densities of the samples, with the process and without: models of the same samples compare.
  double evidence = 0.0, evidence_without = 0.0;
  int sweeps = 0;  // passes over the recording that were needed
  // Minus the second derivatives of G at the maximum, by the logarithms of size^2 / memory, of the
  // memory and, where it was asked for, of the magnetometer's noise; empty: nothing was fitted.
  MatrixXd curvature = {};
};

struct DisturbanceOptions {
  // One step of a maximization from zero gains half of the score's square. Nothing is fitted below
  // this many nats; negative: always.
  double least_gain = 0.5;
  // Is the magnetometer's noise known from elsewhere? Else it may be another beside the process.
  bool mag_noise_known = true;
};

struct DisturbanceSeries {
  std::vector<double> t;             // s, of the recordings one after another
  std::vector<int> recording;        // of each time
  std::vector<Vector3> mean, sigma;  // smoothed, in the process's unit
};

// What the readings say of a field of the place.
struct PlaceEstimate {
  VectorXd theta;
  MatrixXd covariance;
  std::vector<Vector3> shift;  // of each node's position from where the model was fitted, m
};

class DisturbanceModel {
 public:
  // stage: fitted; it must outlive this.
  DisturbanceModel(const Stage& stage, DisturbedPart part, const DisturbanceOptions& options = {});

  // Evidence with the process less that without; size 0: 0. Nats.
  double gain(double size, double memory_s) const;
  DisturbanceFit fit() const;
  // The same from the maximum of a model much like this one.
  DisturbanceFit fit_near(const DisturbanceFit& start) const;
  DisturbanceSeries smooth(const DisturbanceFit& fitted) const;
  // By how much one variable that all nodes share moves when the process is part of the model, in
  // its tangent space, by one step. 0 where nothing is gained.
  VectorXd shift(const DisturbanceFit& fitted, Key global) const;

  // A field of the place beside the process; null: none.
  void set_place(std::shared_ptr<const FieldOfPlace> place);
  PlaceEstimate place(const DisturbanceFit& fitted) const;
  // Samples of magnetometers in these stretches do not count from now on; all others do.
  struct LeftOut {
    int recording;
    TimeSpan span;
  };
  void leave_out(const std::vector<LeftOut>& stretches);
  // Log density of all samples that count, with this process.
  double log_density(const DisturbanceFit& fitted) const;

  double node_s() const { return node_s_; }  // between the process's nodes, in the mean
  double span_s() const { return span_s_; }  // of all recordings

 private:
  struct Slope;
  void add_grid();
  double weight_at(int node, double time) const;
  // What a magnetometer's row sees of itself and of the field.
  struct SeenByMag {
    std::size_t row;
    int node, sensor;
    Vector3 itself, field;
  };
  const std::vector<SeenByMag>& magnetometer_rows();
  void add_magnetometers();
  void add_rates();
  const ProcessChain& chain(double mag_noise) const;
  ProcessRows scaled_rows(double mag_noise) const;
  double log_density(double size, double memory_s, double mag_noise) const;
  Slope slope(double memory_s, double& variance) const;
  void maximize(DisturbanceFit& d, double first_step) const;

  const Stage& stage_;
  DisturbedPart part_;
  DisturbanceOptions options_;
  LinearSystem system_;
  SensorRows sensors_;
  ProcessGrid grid_;
  ProcessRows rows_;
  // Of each node of the model; at_grid_: the last node of the grid not after it.
  std::vector<int> recording_;
  std::vector<double> time_;
  std::vector<std::size_t> at_grid_;
  double node_s_ = 0.0, span_s_ = 0.0, least_variance_ = 0.0;
  std::size_t mag_rows_ = 0;
  std::vector<SeenByMag> seen_by_mag_;  // once asked for
  std::vector<bool> left_out_;          // of each row; empty: none
  std::shared_ptr<const FieldOfPlace> place_;
  mutable double noise_ = 1.0;
  mutable std::unique_ptr<ProcessChain> chain_;
  mutable int sweeps_ = 0;
  mutable DisturbanceFit shifted_for_;  // of which shift_ is
  mutable VectorXd shift_;
};

}  // namespace magimu

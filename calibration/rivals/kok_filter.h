// SPDX-License-Identifier: BSD-3-Clause
// The filter of Kok and Schoen (Magnetometer calibration using inertial sensors, IEEE Sensors
// Journal 16, 2016, section IV), with the 19 parameters of Huang et al. 2025: an extended Kalman
// filter over the orientation alone, whose innovations e with their covariance S give the
// likelihood of the parameters,
//
//   -log p(y | theta) = sum of 1/2 e' S^-1 e + 1/2 log det S + const.
//
// It updates with each step's samples, then predicts with the gyroscope. Samples of one step enter
// row by row, all linearized at the predicted orientation: that is the joint update, and the
// innovations come out as L^-1 e with S = L L'.
#pragma once

#include <functional>
#include <vector>

#include "calibration/motion/filter_samples.h"
#include "factors/sensor_model.h"

namespace magimu {

// What the filter assumes beside the parameters.
struct KokModel {
  double acc_sigma = 0.0;              // of one sample, m/s^2
  std::vector<double> mag_sigma = {};  // of one sample of each magnetometer, uT
  double gyr_density = 0.0;            // rad/s per sqrt(Hz)
  double gravity = kStandardGravity;   // m/s^2
  double start_sigma_rad = 0.0;        // of the orientation at the first step, about each axis
};

// That of a recording whose noise has these densities. start_sigma_rad: of the first orientation.
KokModel kok_model(const Recording& recording, const NoiseDensities& noise, double gravity,
                   double start_sigma_rad);

// Of one recording.
struct KokSums {
  double squares = 0.0;      // sum of e' S^-1 e
  double log_det = 0.0;      // sum of log det S
  double acc_squares = 0.0;  // the accelerometer's part of squares
  long acc_rows = 0, rows = 0;
  double acc_lag = 0.0, mag_lag = 0.0;  // sums of products of neighbouring samples' L^-1 e

  KokSums& operator+=(const KokSums& o);
};

// Parameters of one recording, in this order: o_a, o_w, then D (column by column) and o_m of each
// magnetometer, the dip (rad), and the turn of the first orientation R0 Exp(e).
constexpr Eigen::Index kok_columns(int magnetometers) { return 6 + 12 * magnetometers + 4; }

// Sums of squares over the rows with their sensitivities: J'J and J'w of w = L^-1 e.
struct KokNormal {
  MatrixXd information;
  VectorXd gradient;
};

class KokFilter {
 public:
  // steps must outlive it.
  KokFilter(const std::vector<FilterStep>& steps, KokModel model);

  KokSums run(const SensorParameters& theta, const Rot3& start) const;
  // The same with sensitivities: of the innovations and of the filtered orientation, which are
  // exact for the gains and the S that the filter has at theta. How these change with theta is left
  // out; it adds next to no information (docs of the test: kok_filter_test.cpp).
  KokSums linearize(const SensorParameters& theta, const Rot3& start, KokNormal& normal) const;

  // Orientations at each step after its update, for what is said of the motion.
  std::vector<Rot3> orientations(const SensorParameters& theta, const Rot3& start) const;

  // Of each row: w, its sensitivity to all columns, the gain, and S; for tests.
  struct Row {
    double w = 0.0, S = 0.0;
    Vector3 gain;
    VectorXd sensitivity;
  };
  std::vector<Row> rows(const SensorParameters& theta, const Rot3& start) const;

 private:
  template <class Sensitivity, class Sink>
  KokSums sweep(const SensorParameters& theta, const Rot3& start, Sensitivity&& sensitivity,
                Sink&& after_update) const;

  const std::vector<FilterStep>& steps_;
  KokModel model_;
};

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// How much of an effect outside of the catalogue the catalogue can imitate: its difference to the
// exact recording, projected on those of all the catalogue's linear terms, of the calibration, and
// of attitudes that are wrong by a slowly changing angle. Most of it must be left.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

#include "tests/oracle/mag_model.h"
#include "tests/oracle/sensors.h"

namespace magimu::oracle {
namespace {

using Eigen::Index;

Options noiseless() {
  Options options;
  options.seed = 9;
  options.motion.kind = MotionKind::kHandHeld;
  options.motion.duration_s = 40.0;
  options.rate_hz = 50.0;
  options.noise_factor = 0.0;
  return options;
}

Recording recorded_with(const Effect& effect) {
  Options options = noiseless();
  options.effects = {effect};
  return simulate(options).recording;
}

// Differences of one sensor's readings, one below the other.
VectorXd difference(const VectorSeries& a, const VectorSeries& b) {
  VectorXd all(3 * static_cast<Index>(a.size()));
  for (std::size_t k = 0; k < a.size(); ++k) {
    all.segment<3>(3 * static_cast<Index>(k)) = a.v[k] - b.v[k];
  }
  return all;
}

// What of y no constant explains.
double changing_norm(const VectorXd& y) {
  Vector3d mean = Vector3d::Zero();
  const double n = static_cast<double>(y.size()) / 3.0;
  for (Index k = 0; k < y.size(); k += 3) mean += y.segment<3>(k) / n;
  return std::sqrt(y.squaredNorm() - n * mean.squaredNorm());
}

class Catalogue {
 public:
  Catalogue() : clean_(simulate(noiseless())) {
    add_calibration();
    add_attitude();
    for (const char* name :
         {"acc_scale_misalignment", "gyro_scale_misalignment", "gyro_g_sensitivity",
          "gyro_nonlinearity", "gyro_temperature", "acc_temperature", "mag_temperature",
          "lever_arm", "mag_time_offset", "mag_lag", "mag_eddy_current", "field_drift",
          "hard_iron_drift", "field_gradient", "mag_nonlinearity", "mag_current"}) {
      Effect effect = neutral_effect(name);
      for (Index i = 0; i < effect.parameters.size(); ++i) {
        effect.parameters.setZero();
        effect.parameters[i] = 1e-3;
        add(recorded_with(effect));
      }
    }
  }

  // The part of an effect that is left.
  double left_of(const Effect& effect, Channel channel) const {
    const VectorXd y = differences(recorded_with(effect))[static_cast<std::size_t>(channel)];
    const std::vector<VectorXd>& columns = columns_[static_cast<std::size_t>(channel)];
    Eigen::MatrixXd A(y.size(), static_cast<Index>(columns.size()));
    for (Index i = 0; i < A.cols(); ++i) A.col(i) = columns[static_cast<std::size_t>(i)];
    // The columns have unit length and some are parallel.
    Eigen::MatrixXd normal = A.transpose() * A;
    normal.diagonal().array() += 1e-10;
    const VectorXd x = normal.ldlt().solve(A.transpose() * y);
    return (y - A * x).norm() / changing_norm(y);
  }

 private:
  std::array<VectorXd, 3> differences(const Recording& r) const {
    const Recording& c = clean_.recording;
    return {difference(r.acc, c.acc), difference(r.gyr, c.gyr), difference(r.mag[0], c.mag[0])};
  }
  void add(const Recording& r) {
    const std::array<VectorXd, 3> all = differences(r);
    for (std::size_t i = 0; i < 3; ++i) {
      if (all[i].norm() > 0.0) columns_[i].push_back(all[i].normalized());
    }
  }
  // Biases, D, the dip.
  void add_calibration() {
    for (int i = 0; i < 19; ++i) {
      Device d = clean_.truth.device;
      if (i < 3) d.acc_bias[i] += 1e-3;
      if (i >= 3 && i < 6) d.gyr_bias[i - 3] += 1e-3;
      if (i >= 6 && i < 15) d.distortion(i % 3, (i - 6) / 3) += 1e-3;
      if (i >= 15 && i < 18) d.mag_bias[i - 15] += 1e-3;
      if (i == 18) d.dip_rad += 1e-3;
      Options options = noiseless();
      options.device = d;
      add(simulate(options).recording);
    }
  }
  // Turned in n by an angle that changes with the time as a polynomial: the gyroscope would know
  // little of it.
  void add_attitude() {
    const Device& d = clean_.truth.device;
    for (int i = 0; i < 12; ++i) {
      Recording r = clean_.recording;
      for (std::size_t k = 0; k < clean_.truth.t.size(); ++k) {
        const Matrix3d bRn = clean_.truth.nRb[k].matrix().transpose();
        const double angle = 1e-3 * legendre(i / 3, clean_.truth.t[k] / 20.0 - 1.0);
        const Vector3d turn = angle * Vector3d::Unit(i % 3);
        r.acc.v[k] += bRn * Vector3d(0, 0, 9.8).cross(turn);
        r.mag[0].v[k] += d.distortion * (bRn * d.unit_field().cross(turn));
      }
      add(r);
    }
  }

  Simulation clean_;
  std::array<std::vector<VectorXd>, 3> columns_;  // of each sensor, of unit length
};

TEST(Imitation, no_combination_of_the_catalogues_terms_imitates_an_outside_effect) {
  const Catalogue catalogue;
  for (const std::string& name : outside_effects()) {
    if (name == "sample_repetition") continue;  // it repeats noise
    const Channel channel = name.starts_with("acc")    ? Channel::kAcc
                            : name.starts_with("gyro") ? Channel::kGyr
                                                       : Channel::kMag;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const double left = catalogue.left_of(random_effect(name, seed), channel);
      EXPECT_GT(left, 0.3) << name << ", seed " << seed;
    }
  }
  // The measure itself: it knows what is in the catalogue.
  EXPECT_LT(catalogue.left_of(make_effect("mag_lag", {0.002}), Channel::kMag), 0.1);
  EXPECT_LT(catalogue.left_of(random_effect("gyro_g_sensitivity", 3), Channel::kGyr), 1e-3);
}

}  // namespace
}  // namespace magimu::oracle

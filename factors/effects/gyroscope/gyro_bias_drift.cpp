// SPDX-License-Identifier: BSD-3-Clause
// d o_w = q d(beta): the gyroscope's bias is a random walk. About its own mean, which o_w holds, a
// random walk over a time T is a sum of cosines with independent amplitudes (Karhunen-Loeve),
//
//   o_w + sum_j c_j cos(j pi (t - t_begin) / T),   c_j ~ N(0, (q sqrt(2 T) / (j pi))^2)
//
// so that a few terms carry most of it: 6 of them 91 % of the variance, 16 of them 96 %.

#include <cmath>
#include <utility>

#include "factors/effects/catalogue.h"
#include "factors/effects/drift.h"

namespace magimu {
namespace {

constexpr double kPriorDensity = 3e-4;  // q, rad/s per sqrt(s)

class GyroBiasDrift final : public Effect {
 public:
  explicit GyroBiasDrift(int terms, double density = kPriorDensity)
      : Effect({.name = "gyro_bias_drift",
                .channel = Sensor::kGyr,
                .parameters = drift_parameters(terms, "rad/s", 1e-3),
                .cause = "the gyroscope's bias wanders",
                .separating_motion = "rest now and then",
                .random_process = true,
                .proper_prior = true,
                .without_attitude = true}),
        density_(density) {}

  void jacobian(const SampleState& s, const VectorXd& theta, EffectJacobian J) const override {
    const double first = std::cos(M_PI * 0.5 * (s.u + 1.0));
    double before = 1.0, cosine = first;  // of j - 1 and j times the angle
    for (int j = 1; 3 * j <= theta.size(); ++j) {
      J.middleCols<3>(3 * j - 3) = cosine * Matrix3::Identity();
      before = std::exchange(cosine, 2.0 * first * cosine - before);
    }
  }
  VectorXd prior_sigma(double duration_s) const override {
    VectorXd sigma(size());
    for (int i = 0; i < size(); ++i) {
      const int term = i / 3 + 1;
      sigma[i] = density_ * std::sqrt(2.0 * duration_s) / (term * M_PI);
    }
    return sigma;
  }
  std::shared_ptr<const Effect> with_terms(int terms) const override {
    return std::make_shared<GyroBiasDrift>(terms, density_);
  }

 private:
  double density_;
};

}  // namespace

std::unique_ptr<Effect> make_gyro_bias_drift() { return std::make_unique<GyroBiasDrift>(3); }

std::shared_ptr<const Effect> make_gyro_bias_walk(int terms, double density) {
  return std::make_shared<GyroBiasDrift>(terms, density);
}

}  // namespace magimu

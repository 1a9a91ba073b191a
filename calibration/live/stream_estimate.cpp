// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/stream_estimate.h"

#include <Eigen/LU>
#include <cmath>

#include "calibration/calibrate.h"
#include "calibration/fit/diagnostics.h"
#include "calibration/fit/uncertainty.h"
#include "calibration/model/parameter_names.h"
#include "calibration/motion/nodes.h"
#include "graph/decompositions.h"
#include "solvers/sandwich.h"

namespace magimu {
namespace {

constexpr double kFewBlocks = 45.0;  // s, nine blocks of the robust covariance

// P, widened direction by direction as the robust covariance of `last` is wider than its model's
// (in coordinates in which the model's is the identity); on the whole at least by `least`.
MatrixXd widened_like(const Calibration& last, double last_s, double least, const MatrixXd& P) {
  const Eigen::LLT<MatrixXd> before(last.covariance_model), now(P);
  if (before.info() != Eigen::Success || now.info() != Eigen::Success) return P * least;
  MatrixXd M = last.covariance;
  before.matrixL().solveInPlace(M);
  M.transposeInPlace();
  before.matrixL().solveInPlace(M);
  // From few blocks only the mean widening over all directions is known. That mean is known well,
  // so the allowance for the uncertainty in a single direction is taken out.
  if (last_s < kFewBlocks) {
    const int blocks = std::max(1, int(last_s / CalibrationOptions{}.block_s));
    return P * std::max(least, M.trace() / double(M.rows()) / student_variance(blocks));
  }
  const MatrixXd L = now.matrixL();
  return std::max(1.0, least * double(M.rows()) / M.trace()) * (L * M * L.transpose());
}

}  // namespace

Calibration stream_estimate(const IncrementalQr& estimator, const ModelSpec& spec,
                            const Calibration& last, double last_s, double least_widening) {
  Calibration c = last;
  const Values& values = estimator.globals();
  const int mags = int(last.parameters.mag.size());
  c.parameters.acc_bias = values.at<Vector3>(key::acc_bias);
  c.parameters.gyr_bias = values.at<Vector3>(key::gyr_bias);
  c.parameters.dip_rad = values.at<double>(dip_of(0));
  for (int m = 0; m < mags; ++m) {
    c.parameters.mag[std::size_t(m)] = {values.at<Matrix3>(key::distortion_of(m)),
                                        values.at<Vector3>(key::mag_bias_of(m))};
  }
  const MatrixXd P = estimator.covariance(parameter_keys(mags, 1, spec));
  VectorXd unit = VectorXd::Ones(P.rows());
  const Eigen::Index dip = 6 + 12 * mags;
  unit[dip] = 1.0 / kDegree;
  c.covariance_model = unit.asDiagonal() * P * unit.asDiagonal();
  c.covariance = widened_like(last, last_s, least_widening, c.covariance_model);
  for (LeverArm& arm : c.lever_arms) {
    arm.value = values.at<Vector3>(key::lever_arm_of(0));
    arm.covariance = estimator.covariance({key::lever_arm_of(0)});
  }
  FieldEstimate& field = c.fields.front();
  field.dip_rad = c.parameters.dip_rad;
  field.dip_sigma_rad = std::sqrt(c.covariance(dip, dip)) * kDegree;
  field.dip_sigma_model_rad = std::sqrt(c.covariance_model(dip, dip)) * kDegree;
  const Matrix3& D = c.parameters.mag.front().distortion;
  c.strength_uT = std::cbrt(D.determinant());
  c.strength_sigma_uT = strength_sigma(D, c.strength_uT, c.covariance);
  c.strength_sigma_model_uT = strength_sigma(D, c.strength_uT, c.covariance_model);
  for (ActiveEffect& effect : c.effects) {
    for (std::size_t m = 0; m < effect.parameters.size(); ++m) {  // lags are the only ones here
      effect.parameters[m].value = values.at<double>(key::mag_time_offset_of(int(m)));
      effect.parameters[m].sigma = c.sigma(effect.parameters[m].name);
      effect.parameters[m].sigma_model = c.sigma_model(effect.parameters[m].name);
    }
  }
  return c;
}

double heading_sigma_deg(const Calibration& c) {
  return check_accuracy(c).value / std::max(0.05, std::cos(c.parameters.dip_rad));
}

}  // namespace magimu

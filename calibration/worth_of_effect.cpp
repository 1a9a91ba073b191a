// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/worth_of_effect.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "calibration/fit/marginal_likelihood.h"
#include "calibration/fit/summary.h"
#include "calibration/model/extension.h"

namespace magimu {

double worth_of_last_effect(const std::vector<const Recording*>& recordings, const Stage& without,
                            const Stage& with, const CalibrationOptions& options) {
  const double gain = log_marginal_likelihood(with) - log_marginal_likelihood(without);
  if (!(gain > 0.0)) return gain;
  const Calibration c = summarize_parameters(recordings, with, options);
  const VectorXd theta =
      effect_parameters(with.result().values, effect_keys(with.spec().effects).back());
  const auto squares = [&](const MatrixXd& covariance) {
    const Eigen::Index n = theta.size();
    return theta.dot(MatrixXd(covariance.bottomRightCorner(n, n)).ldlt().solve(theta));
  };
  return gain - 0.5 * std::max(0.0, squares(c.covariance_model) - squares(c.covariance));
}

}  // namespace magimu

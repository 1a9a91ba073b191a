// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/worth_of_effect.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "calibration/fit/summary.h"
#include "calibration/model/extension.h"

namespace magimu {

double worth_of_effects(const std::vector<const Recording*>& recordings, const Stage& with,
                        std::size_t first, double gain, const CalibrationOptions& options) {
  if (!(gain > 0.0)) return gain;
  const Calibration c = summarize_parameters(recordings, with, options);
  std::vector<Key> keys;
  const std::vector<std::vector<Key>> all = effect_keys(with.spec().effects);
  for (std::size_t e = first; e < all.size(); ++e) {
    keys.insert(keys.end(), all[e].begin(), all[e].end());
  }
  const VectorXd theta = effect_parameters(with.result().values, keys);
  const auto squares = [&](const MatrixXd& covariance) {
    const Eigen::Index n = theta.size();
    return theta.dot(MatrixXd(covariance.bottomRightCorner(n, n)).ldlt().solve(theta));
  };
  return gain - 0.5 * std::max(0.0, squares(c.covariance_model) - squares(c.covariance));
}

}  // namespace magimu

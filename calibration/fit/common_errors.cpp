// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/fit/common_errors.h"

#include <algorithm>
#include <cmath>

namespace magimu {

MatrixXd covariance_of_common(const std::vector<MatrixXd>& parts, const MatrixXd& covariance) {
  const VectorXd weight =
      covariance.diagonal().unaryExpr([](double v) { return v > 0.0 ? 1.0 / v : 0.0; });
  std::vector<double> size;
  double sum = 0.0;
  for (const MatrixXd& part : parts) {
    size.push_back(std::sqrt(std::max(0.0, part.diagonal().dot(weight))));
    sum += size.back();
  }
  MatrixXd out = MatrixXd::Zero(covariance.rows(), covariance.cols());
  for (std::size_t r = 0; r < parts.size(); ++r) {
    if (size[r] > 0.0) out += sum / size[r] * parts[r];
  }
  return out;
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/result/calibration.h"

#include <algorithm>
#include <stdexcept>

namespace magimu {
namespace {

double sigma_in(const Calibration& c, const MatrixXd& covariance, const std::string& name) {
  const auto it = std::find(c.order.begin(), c.order.end(), name);
  if (it == c.order.end()) throw std::invalid_argument("no calibration parameter " + name);
  const auto i = it - c.order.begin();
  return std::sqrt(covariance(i, i));
}

}  // namespace

std::string to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kYes:
      return "yes";
    case Verdict::kLimited:
      return "limited";
    case Verdict::kNo:
      return "no";
  }
  return "?";
}

std::string to_string(CheckStatus status) {
  switch (status) {
    case CheckStatus::kOk:
      return "ok";
    case CheckStatus::kCaution:
      return "caution";
    case CheckStatus::kBad:
      return "bad";
  }
  return "?";
}

void Trust::lower(Verdict to, const std::string& reason) {
  const bool graver = to > verdict;
  verdict = std::max(verdict, to);
  reasons.insert(graver ? reasons.begin() : reasons.end(), reason);
}

double Calibration::sigma(const std::string& name) const {
  return sigma_in(*this, covariance, name);
}
double Calibration::sigma_model(const std::string& name) const {
  return sigma_in(*this, covariance_model, name);
}

}  // namespace magimu

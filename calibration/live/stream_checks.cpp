// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/stream_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/motion/nodes.h"
#include "calibration/result/parameter_vector.h"
#include "calibration/result/spoken_names.h"
#include "factors/keys.h"

namespace magimu {
namespace {

constexpr double kSpan = 10.0, kLeastSpan = 2.5;  // s
constexpr double kHardly = 0.98;  // of the earlier distance: the uncertainty hardly falls
constexpr double kUnlikely =
    4.5;  // standard deviations: the largest of some twenty changes is less
constexpr double kRounding =
    0.1;  // of a standard deviation: relinearization alone may move parameters so far
constexpr double kMuchMore = 2.0;  // times the expected innovations
constexpr double kManyLeftOut = 0.3;

std::string name_of(Eigen::Index parameter, Eigen::Index count) {
  if (parameter < 3) return spoken_name(key::acc_bias);
  if (parameter < 6) return spoken_name(key::gyr_bias);
  if (parameter == count - 1) return spoken_name(dip_of(0));
  const int m = int(parameter - 6) / 12;
  const bool bias = (parameter - 6) % 12 >= 9;
  return spoken_name(bias ? key::mag_bias_of(m) : key::distortion_of(m));
}

}  // namespace

void StreamChecks::add(double t, const Calibration& c, double distance, const WindowFit& window) {
  const VectorXd theta = parameter_vector(c).head(7 + 12 * Eigen::Index(c.parameters.mag.size()));
  // What passed while there was nothing to see is not counted, nor a clock that was set.
  const double passed = moments_.empty() ? 0.0 : t - moments_.back().t;
  if (passed > kSpan || passed < 0.0) {
    for (Moment& m : moments_) m.t += passed;
  }
  moments_.push_back(
      {t, distance, theta, c.covariance.diagonal().head(theta.size()).cwiseMax(0.0), window});
  while (moments_.size() > 2 && moments_[1].t <= t - kSpan) moments_.pop_front();
}

std::vector<Check> StreamChecks::checks() const {
  if (moments_.empty() || moments_.back().t - moments_.front().t < kLeastSpan) return {};
  return {trend(), windows(), stability()};
}

Check StreamChecks::trend() const {
  const Moment &then = moments_.front(), &now = moments_.back();
  const bool falls = now.distance <= 1.0 || now.distance < kHardly * then.distance;
  return {"trend", falls ? CheckStatus::kOk : CheckStatus::kCaution, now.distance / then.distance,
          fmt::format("In {:.0f} s the uncertainty has come from {:.2g} to {:.2g} times what is "
                      "wanted{}",
                      now.t - then.t, then.distance, now.distance,
                      falls ? "." : ": this motion shows little that is new.")};
}

Check StreamChecks::windows() const {
  double ratio = 0.0;
  int judged = 0, out = 0;
  for (auto m = moments_.begin() + 1; m != moments_.end(); ++m) {
    out += m->window.used ? 0 : 1;
    if (m->window.dof == 0 || !m->window.used) continue;
    ratio += m->window.nis / m->window.dof;
    ++judged;
  }
  const auto all = int(moments_.size()) - 1;
  const double mean = judged > 0 ? ratio / judged : 1.0;
  const bool fit = mean < kMuchMore && out <= kManyLeftOut * all;
  return {"windows", fit ? CheckStatus::kOk : CheckStatus::kCaution, mean,
          fmt::format("{} of the last {} windows fit the rest; their innovations are {:.2g} times "
                      "as large as the noise lets expect{}",
                      all - out, all, std::sqrt(mean),
                      fit ? "." : ": is something magnetic nearby, or moved?")};
}

Check StreamChecks::stability() const {
  const Moment &then = moments_.front(), &now = moments_.back();
  const VectorXd gained = (then.variance - now.variance).cwiseMax(0.0) +
                          kRounding * kRounding * now.variance.cwiseMax(1e-300);
  Eigen::Index which = 0;
  const double largest =
      (now.theta - then.theta).cwiseAbs().cwiseQuotient(gained.cwiseSqrt()).maxCoeff(&which);
  const bool stable = largest < kUnlikely;
  const double seconds = now.t - then.t;
  return {
      "stability", stable ? CheckStatus::kOk : CheckStatus::kCaution, largest,
      stable ? fmt::format("In {:.0f} s no parameter has moved by more than {:.2g} times what new "
                           "samples explain.",
                           seconds, largest)
             : fmt::format("In {:.0f} s {} has moved by {:.2g} times what new samples explain: the "
                           "standard deviations are too small, or something has changed.",
                           seconds, name_of(which, now.theta.size()), largest)};
}

}  // namespace magimu

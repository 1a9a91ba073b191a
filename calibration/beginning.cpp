// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/beginning.h"

#include <algorithm>
#include <cmath>

#include "calibration/fit/summary.h"
#include "calibration/fit/uncertainty.h"
#include "calibration/model/parameter_names.h"
#include "graph/numerical_error.h"

namespace magimu {
namespace {

constexpr const char* kLag = "acc_time_offset";
constexpr double kSeen = 2.0;  // standard deviations, from which the samples are put right
// Of what is left after that, again: a lag is linear in the model, and a force bends meanwhile.
constexpr int kMostShifts = 2;

std::vector<const Recording*> with_acc_earlier(const std::vector<const Recording*>& given,
                                               double by_s, std::deque<Recording>& copies) {
  if (by_s == 0.0) return given;
  std::vector<const Recording*> out;
  for (const Recording* r : given) {
    Recording& copy = copies.emplace_back(*r);
    for (double& t : copy.acc.t) t -= by_s;
    out.push_back(&copy);
  }
  return out;
}

}  // namespace

Beginning::Fit::Fit(const std::vector<const Recording*>& given, double acc_late_s,
                    const CalibrationOptions& options, const std::vector<std::string>& known)
    : recordings(with_acc_earlier(given, acc_late_s, copies)),
      few(recordings),
      pipeline(few.get(), options),
      coarse(pipeline.coarse(motion_reason, known)) {}

std::optional<Beginning::Lag> Beginning::lag_of(const Fit& fit, const CalibrationOptions& options) {
  // Who says that there is no lag has one clock.
  if (!options.mag_time_offset.value_or(true) || !fit.coarse.result().converged()) {
    return std::nullopt;
  }
  ModelSpec spec = fit.coarse.spec();
  spec.effects.push_back(find_effect(kLag));
  const auto lagging =
      attempt([&] { return fit.pipeline.refit_with_same_noise(fit.coarse, spec); });
  if (!lagging || !lagging->result().converged()) return std::nullopt;
  const Calibration c = summarize_parameters(fit.few.get(), *lagging, options);
  const Eigen::Index last = c.covariance_model.rows() - 1;
  if (c.effects.empty() || c.effects.back().name != kLag || !c.undetermined.empty()) {
    return std::nullopt;
  }
  const ActiveEffect::Parameter& tau = c.effects.back().parameters.front();
  if (!(tau.sigma_model > 0.0)) return std::nullopt;
  return Lag{tau.value, tau.sigma_model, std::max(tau.sigma, tau.sigma_model),
             c.covariance_model.col(last).head(last) / c.covariance_model(last, last)};
}

Beginning::Beginning(const std::vector<const Recording*>& all, const CalibrationOptions& options)
    : fit_(std::make_unique<Fit>(all, 0.0, options)), lag_(lag_of(*fit_, options)) {
  CalibrationOptions same_motion = options;
  // A force that belongs to another attitude carries a hand beyond its reach: whether the sensor
  // travelled is asked again.
  const MotionModel motion = fit_->coarse.spec().motion;
  if (motion != MotionModel::kTravelling) same_motion.motion = motion;
  for (int shift = 0; shift < kMostShifts; ++shift) {
    if (!lag_ || !(std::abs(lag_->tau_s) > kSeen * lag_->robust_s)) return;
    std::vector<std::string> known;
    for (const auto& effect : fit_->coarse.spec().effects) known.push_back(effect->name());
    auto next = attempt(
        [&] { return std::make_unique<Fit>(all, late_s_ + lag_->tau_s, same_motion, known); });
    if (!next || !(*next)->coarse.result().converged()) return;
    if (same_motion.motion != MotionModel::kAuto) (*next)->motion_reason = fit_->motion_reason;
    late_s_ += lag_->tau_s;
    fit_ = *std::move(next);
    const std::optional<Lag> left = lag_of(*fit_, options);
    if (!left) {  // nothing tells: as sure as before
      lag_->tau_s = 0.0;
      return;
    }
    lag_ = left;
  }
}

void Beginning::add_doubt(Calibration& c, CondensedRecording* condensed) const {
  if (!lag_) return;
  MissingEffect doubt;
  doubt.shift = lag_->tau_s * lag_->moves;
  doubt.covariance = lag_->sigma_s * lag_->sigma_s * lag_->moves * lag_->moves.transpose();
  if (!fit_->few.are_all()) {
    doubt = of_all_magnetometers(doubt, fit_->coarse.spec(), field_count(fit_->recordings), c);
  }
  const MatrixXd more = doubt.shift * doubt.shift.transpose() + doubt.covariance;
  c.covariance_model += more;
  add_to_covariance(c, more);
  if (condensed != nullptr) widen(*condensed, more);
}

void Beginning::add_lag(Calibration& c) const {
  if (late_s_ == 0.0 || !lag_) return;
  const double tau = late_s_ + lag_->tau_s;
  c.effects.push_back({kLag, {{effect_parameter_name(*find_effect(kLag), 0), "s", tau}}});
  ActiveEffect::Parameter& p = c.effects.back().parameters.front();
  p.sigma = lag_->robust_s;
  p.sigma_model = lag_->sigma_s;
}

}  // namespace magimu

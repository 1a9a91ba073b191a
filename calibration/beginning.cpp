// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/beginning.h"

#include <algorithm>
#include <cmath>

#include "calibration/model/extension.h"
#include "calibration/model/parameter_names.h"
#include "graph/numerical_error.h"

namespace magimu {
namespace {

constexpr const char* kLag = "acc_time_offset";
// s: within, a force that swings at 4 Hz differs from its tangent by a thousandth of itself.
constexpr double kBends = 2e-3;
constexpr int kMostShifts = 3;

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

// s; nothing where the model has no lag.
std::optional<double> lag_of(const Stage& stage) {
  const auto& effects = stage.spec().effects;
  for (std::size_t i = 0; i < effects.size(); ++i) {
    if (effects[i]->name() != kLag) continue;
    return stage.result().values.at<double>(effect_keys(effects)[i].front());
  }
  return std::nullopt;
}

}  // namespace

Beginning::Fit::Fit(const std::vector<const Recording*>& given, double acc_late_s,
                    const CalibrationOptions& options)
    : recordings(with_acc_earlier(given, acc_late_s, copies)),
      few(recordings),
      pipeline(few.get(), options),
      coarse(pipeline.coarse(motion_reason)) {}

Beginning::Beginning(const std::vector<const Recording*>& all, const CalibrationOptions& options)
    : fit_(std::make_unique<Fit>(all, 0.0, options)) {
  for (int shift = 0; shift < kMostShifts; ++shift) {
    const std::optional<double> lag = lag_of(fit_->coarse);
    if (!lag || std::abs(*lag) < kBends) return;
    auto next = attempt([&] { return std::make_unique<Fit>(all, late_s_ + *lag, options); });
    // What is left of it stays in the model.
    if (!next || !(*next)->coarse.result().converged() || !lag_of((*next)->coarse)) return;
    late_s_ += *lag;
    fit_ = *std::move(next);
  }
}

void Beginning::add_lag(Calibration& c) const {
  for (ActiveEffect& effect : c.effects) {
    if (effect.name == kLag) effect.parameters.front().value += late_s_;
  }
}

void Beginning::add_lag(CondensedRecording& condensed) const {
  const std::string name = effect_parameter_name(*find_effect(kLag), 0);
  const auto at = std::ranges::find(condensed.order, name) - condensed.order.begin();
  if (std::size_t(at) == condensed.order.size()) return;
  condensed.at[at] += late_s_;
  condensed.prior_mean[at] += late_s_;
}

}  // namespace magimu

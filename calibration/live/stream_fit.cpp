// SPDX-License-Identifier: BSD-3-Clause
// How a stream gets its first estimate, and while it is short a better one: batch calibration with
// few nodes, of all windows there are. It finds the noise, the lag of the magnetometer and, from a
// blind start, the right minimum; the estimator then goes on from its optimum.
#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/fit/diagnostics.h"
#include "calibration/fit/summary.h"
#include "calibration/live/stream_state.h"
#include "factors/prior_factor.h"
#include "graph/numerical_error.h"

namespace magimu {
namespace {

constexpr double kNodeRate = 12.0;  // a second, at the most: as in the pipeline's coarse fits
constexpr double kRateUncertain =
    1.05;  // factor by which the sampling rate may turn out to be higher
constexpr double kRepeatsDropped = 0.3;   // of a magnetometer's samples
constexpr double kTriedOften = 20.0;      // s: a stream this short is fitted at every update,
constexpr double kTryAgain = 1.15;        // and later each time it is longer by this factor
constexpr double kUsable = 15.0;          // deg, accuracy of a first calibration
constexpr double kResidualUsable = 0.15;  // of the field
constexpr double kAccBiasSigma = 1.0;     // m/s^2: of any part that works
constexpr double kLagShown = 4.0;         // standard deviations of a lag that is believed

bool shows_offset(const Calibration& c) {
  return std::any_of(c.effects.front().parameters.begin(), c.effects.front().parameters.end(),
                     [](const ActiveEffect::Parameter& p) {
                       return std::abs(p.value) > kLagShown * std::max(p.sigma, p.sigma_model);
                     });
}

}  // namespace

void StreamingCalibration::State::try_to_start() {
  const double length = samples_.last_t() - samples_.first_t();
  next_try_ = length < kTriedOften ? length : kTryAgain * length;  // at every update, or rarely
  if (samples_.repeats() > kRepeatsDropped) samples_.drop_repeats();
  const double rate = samples_.all().mag.front().rate_hz();
  const int every = std::max(1, int(std::ceil(kRateUncertain * rate / kNodeRate)));
  samples_.set_nodes(every);
  batch_.node_every = every;
  if (!samples_.windows().empty()) fit_all_windows();
}

// False, and no change, if the data do not permit a fit.
bool StreamingCalibration::State::fit_all_windows() {
  const StreamParts parts = samples_.parts(int(samples_.windows().size()));
  const std::vector<const Recording*> recordings = parts.pointers();
  std::optional<Stage> stage;
  // A blind start would use all samples. If windows are left out, start from the present estimate.
  const bool blind = flagged_.empty() && changes_.empty();
  const bool fitted = attempt([&] {
                        return (blind ? fit_from_blind_start(recordings, parts.plans, stage)
                                      : fit_from_estimate(recordings, parts.plans, stage)) &&
                               take_over_fit(recordings, *stage);
                      }).value_or(false);
  if (!fitted) return false;
  judge_all_windows();
  return true;
}

// Fits from a blind start: a minimum found with less data is given up if there is a better one.
bool StreamingCalibration::State::fit_from_blind_start(
    const std::vector<const Recording*>& recordings, const std::vector<NodePlan>& plans,
    std::optional<Stage>& stage) const {
  const Pipeline pipeline(recordings, batch_, plans);
  stage = pipeline.coarse_fit(batch_.motion);
  if (!stage->result().converged()) return false;
  ModelSpec spec = stage->spec();
  spec.mag_time_offset = true;
  const Stage delayed = pipeline.refit(*stage, spec);
  if (delayed.result().converged() &&
      shows_offset(summarize_parameters(recordings, delayed, batch_))) {
    stage = delayed;
  }
  stage = pipeline.with_fixed_symmetries(*stage);
  return true;
}

bool StreamingCalibration::State::fit_from_estimate(const std::vector<const Recording*>& recordings,
                                                    const std::vector<NodePlan>& plans,
                                                    std::optional<Stage>& stage) const {
  ModelSpec spec = spec_;
  spec.without_mag = left_out();
  stage.emplace(recordings, spec, plans, batch_.optimizer);
  const bool given = batch_.noise.has_value();
  stage->fit_noise(estimator_->estimate(), false,
                   {.gyr_known = true, .acc_known = true, .mag_known = given});
  return true;
}

bool StreamingCalibration::State::take_over_fit(const std::vector<const Recording*>& recordings,
                                                const Stage& stage) {
  Calibration c = summarize(recordings, stage, batch_);
  undetermined_ = c.undetermined;
  if (!c.fit.converged() || !c.undetermined.empty() || check_accuracy(c).value > kUsable ||
      c.residuals[2].rms_unit > kResidualUsable * c.strength_uT) {
    return false;
  }
  const ModelSpec before = std::exchange(spec_, stage.spec());
  spec_.without_mag = nullptr;
  spec_.acc_rate_hz = recordings.front()->acc.rate_hz();
  spec_.mag_rate_hz = recordings.front()->mag.front().rate_hz();
  spec_.reach_at = reach_every_few_seconds(samples_);
  if (is_moved(spec_.motion)) {
    // Holds it until a hand's reach does.
    spec_.also = [known = batch_.also](FactorGraph& graph) {
      if (known) known(graph);
      graph.add(
          PriorFactor<Vector3>(key::acc_bias, Vector3::Zero(), Noise<3>::isotropic(kAccBiasSigma)));
    };
  }
  std::shared_ptr<StreamMaker> maker;
  std::optional<IncrementalQr> estimator = attempt([&] { return rebuilt(c.fit.values, maker); });
  if (!estimator || !estimator->null_space().empty()) {
    spec_ = before;
    return false;
  }
  estimator_ = std::move(estimator);
  maker_ = std::move(maker);
  last_fit_windows_ = estimator_->windows();
  on_the_way_.forget();  // other noise, other standard deviations
  c.fit.values = {};
  c.trajectories.clear();
  last_fit_ = std::move(c);
  last_fit_s_ = 0.0;
  for (const Recording* recording : recordings) last_fit_s_ += recording->duration_s();
  return true;
}

// The estimator with all windows anew, linearized at these values.
IncrementalQr StreamingCalibration::State::rebuilt(const Values& values,
                                                   std::shared_ptr<StreamMaker>& maker) const {
  maker = std::make_shared<StreamMaker>(samples_, spec_);
  IncrementalQr out(estimator_options(maker, options_.awake));
  for (int i = 0; i < int(samples_.windows().size()); ++i) {
    const StreamWindow& w = samples_.windows()[std::size_t(i)];
    WindowFactors f = window_factors(samples_, w, spec_, nullptr);
    take_over(w, spec_, values, f);
    const bool flagged = std::find(flagged_.begin(), flagged_.end(), i) != flagged_.end();
    maker->made(i, spec_);
    out.append(std::move(f.motion), f.values, std::move(f.field), flagged);
  }
  out.idle();
  return out;
}

}  // namespace magimu

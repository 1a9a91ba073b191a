// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/calibrate.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "calibration/condensed_recording.h"
#include "calibration/fit/diagnostics.h"
#include "calibration/fit/given_noise.h"
#include "calibration/fit/parameter_prior.h"
#include "calibration/fit/residual_series.h"
#include "calibration/fit/summary.h"
#include "calibration/fit/uncertainty.h"
#include "calibration/model/held_globals.h"
#include "calibration/model/parameter_names.h"
#include "calibration/motion/blows.h"
#include "calibration/pipeline.h"
#include "calibration/result/parameter_vector.h"
#include "calibration/scan/lacking_state.h"
#include "calibration/scan/missing_effects.h"
#include "calibration/trust/check_axes.h"
#include "calibration/trust/no_fit.h"
#include "calibration/trust/trust.h"
#include "graph/numerical_error.h"
#include "graph/parallel.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

// Halves of a recording that disagree beyond their uncertainty show an error that persists longer
// than the blocks from which the uncertainty comes: it grows to what the halves show.
void widen_by_halves(Calibration& c) {
  for (Check& check : c.checks) {
    if (check.name != "halves" || check.status == CheckStatus::kOk) continue;
    widen_uncertainty(c, check.value);
    check.sentence += fmt::format(" All sigmas were multiplied by {:.1f}.", check.value);
  }
}

// The same stage with its parameters held where the calibration has them: motion and residuals that
// belong to them.
Stage with_parameters_of(const Calibration& c, const Stage& stage) {
  const int magnetometers = int(c.parameters.mag.size()), recordings = int(c.fields.size());
  const Values globals =
      as_globals(c, parameter_keys(magnetometers, recordings, stage.spec()), parameter_vector(c));
  VectorXd sigma = c.covariance_model.diagonal().cwiseSqrt();
  sigma.segment(6 + 12 * magnetometers, recordings) *= kDegree;
  ModelSpec spec = stage.spec();
  spec.also = [also = spec.also, globals, sigma](FactorGraph& graph) {
    if (also) also(graph);
    hold_globals(globals, sigma, graph);
  };
  Values start = stage.result().values;
  std::vector<double> numbers(start.data().begin(), start.data().end());
  for (const Values::Slot& slot : globals.slots()) {
    std::copy_n(globals.data().begin() + slot.stored, slot.type.stored(),
                numbers.begin() + start.slot(slot.key).stored);
  }
  start.assign(numbers);
  Stage held(stage, spec);
  held.fit(start, true);
  return held;
}

// What is known beforehand, taken into the estimate.
void add_prior(Calibration& c, const std::vector<const Recording*>& recordings, const Stage& fine,
               const CalibrationOptions& options, std::vector<double>& mag_squares) {
  // In standard deviations of the model, squared and halved: closer, no residual shows it.
  constexpr double kShows = 0.5;
  const double cost = take_known_beforehand(c, options);
  if (cost < kShows || !c.undetermined.empty()) return;
  const Stage held = with_parameters_of(c, fine);
  if (!held.result().converged()) return;
  const Optimum optimum(held);
  const Calibration there = summarize(recordings, optimum, options);
  c.fit.values = there.fit.values;
  c.trajectories = there.trajectories;
  c.residuals = there.residuals;
  c.residual_series = residual_series(optimum, c.mag_names);
  mag_squares = held.mag_squares(optimum.rows, optimum.system.residual());
}

}  // namespace

Calibration calibrate(const Recording& recording, const CalibrationOptions& options) {
  return calibrate(std::vector<const Recording*>{&recording}, options);
}

namespace {

// Throws NumericalError where no fit can be made. condensed: wanted where not null.
Calibration calibrate_checked(const CheckedRecordings& checked, const CalibrationOptions& options,
                              Mounting& mounting, std::optional<CondensedRecording>* condensed) {
  const std::vector<const Recording*>& recordings = checked.get();
  std::optional<Pipeline> begun;
  std::optional<Stage> found;
  std::string motion_reason;
  parallel::invoke(
      [&] {
        begun.emplace(recordings, options);
        found = begun->coarse(motion_reason);
      },
      [&] { mounting = check_mounting(recordings); });
  const Pipeline& pipeline = *begun;
  const Stage& coarse = *found;
  Calibration c;
  std::vector<double> mag_squares;
  std::vector<Check> checks;
  std::vector<MissingEffect> missing;
  std::optional<Stage> fine;
  std::optional<MissingEffect> lacking;
  parallel::invoke(
      [&] {
        fine = pipeline.fine(coarse);
        const Optimum optimum(*fine);
        c = summarize(recordings, optimum, options);
        if (condensed != nullptr) {
          *condensed = condense_optimum(optimum, int(c.mag_names.size()), c.covariance);
        }
        c.residual_series = residual_series(optimum, c.mag_names);
        mag_squares = fine->mag_squares(optimum.rows, optimum.system.residual());
      },
      [&] { checks = pipeline.check_prediction(coarse); },
      [&] {
        if (!coarse.result().converged()) return;
        if (auto seen = attempt([&] { return find_missing_effects(recordings, coarse); })) {
          missing = *std::move(seen);
        }
      },
      [&] {
        if (!coarse.result().converged()) return;
        if (auto state = attempt([&] { return find_lacking_state(coarse); })) lacking = *state;
      });
  c.motion_reason = motion_reason;
  c.checks = checks;
  c.warnings = checked.warnings();
  c.node_every = pipeline.node_every();
  widen_by_halves(c);
  std::vector<std::string> unknown = unknown_directions(c);
  if (lacking) missing.push_back(*lacking);
  if (coarse.result().converged()) add_missing_effects(c, missing);
  add_prior(c, recordings, *fine, options, mag_squares);
  if (c.prior.source != "none") {
    for (std::string& reason : unknown) reason = "By this recording alone: " + reason;
  }
  for (const Recording* r : recordings) {
    c.blows_per_minute = std::max(c.blows_per_minute, blows_per_minute(*r));
  }
  c.disturbances = find_disturbances(c, mag_squares);
  const Check first[] = {check_optimum(c.fit), check_accuracy(c), check_whiteness(c),
                         check_windows(c, mag_squares)};
  c.checks.insert(c.checks.begin(), std::begin(first), std::end(first));
  judge(c, unknown);
  return c;
}

}  // namespace

namespace {

Calibration calibrate_judged(const std::vector<const Recording*>& given,
                             const CalibrationOptions& options,
                             std::optional<CondensedRecording>* condensed) {
  const auto start = std::chrono::steady_clock::now();
  const CheckedRecordings checked(given);
  Mounting mounting;
  std::string why;
  std::optional<Calibration> made =
      attempt([&] { return calibrate_checked(checked, options, mounting, condensed); }, &why);
  Calibration c = made ? *std::move(made)
                       : calibration_without_fit(checked.get(), options, why, checked.warnings());
  judge_given_noise(c, checked.get(), options);
  judge_axes(c, mounting, options);
  name_faults_first(c.trust, checked.faults());
  c.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return c;
}

Calibration calibrate_anyhow(const std::vector<const Recording*>& given,
                             const CalibrationOptions& options,
                             std::optional<CondensedRecording>* condensed) {
  try {
    return calibrate_judged(given, options, condensed);
  } catch (const TooLittle& too_little) {
    return calibration_without_fit(given, options, too_little);
  }
}

}  // namespace

Calibration calibrate(const std::vector<const Recording*>& given,
                      const CalibrationOptions& options) {
  return calibrate_anyhow(given, options, nullptr);
}

Calibration calibrate_condensed(const Recording& recording, const CalibrationOptions& options,
                                std::optional<CondensedRecording>& condensed) {
  condensed.reset();
  return calibrate_anyhow({&recording}, options, &condensed);
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/calibrate.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "calibration/array_fit.h"
#include "calibration/beginning.h"
#include "calibration/calibrate_whole.h"
#include "calibration/condensed_recording.h"
#include "calibration/fit/bent_posterior.h"
#include "calibration/fit/diagnostics.h"
#include "calibration/fit/given_noise.h"
#include "calibration/fit/moved_by_blocks.h"
#include "calibration/fit/parameter_prior.h"
#include "calibration/fit/residual_series.h"
#include "calibration/fit/side_by_side.h"
#include "calibration/fit/summary.h"
#include "calibration/fit/uncertainty.h"
#include "calibration/model/held_globals.h"
#include "calibration/model/parameter_names.h"
#include "calibration/motion/blows.h"
#include "calibration/motion/slower_recordings.h"
#include "calibration/pipeline.h"
#include "calibration/result/parameter_vector.h"
#include "calibration/scan/lacking_state.h"
#include "calibration/scan/misfit_cause.h"
#include "calibration/scan/missing_effects.h"
#include "calibration/trust/check_axes.h"
#include "calibration/trust/disturbances.h"
#include "calibration/trust/magnetometer_trust.h"
#include "calibration/trust/no_fit.h"
#include "calibration/trust/trust.h"
#include "calibration/turning_rates.h"
#include "graph/numerical_error.h"
#include "graph/parallel.h"
#include "recording/data/error.h"
#include "recording/data/well_formed.h"

namespace magimu {
namespace {

// Halves of a recording, or recordings, that disagree beyond their uncertainty show an error that
// persists longer than the blocks from which the uncertainty comes: it grows to what the halves
// show.
void widen_by_halves(Calibration& c) {
  for (Check& check : c.checks) {
    const bool compares = check.name == "halves" || check.name == "recordings";
    if (!compares || check.status == CheckStatus::kOk) continue;
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

// One of the files' numbers of the gyroscope, rad/s; 0 where the files have different units.
double gyr_unit_of_files(const std::vector<const Recording*>& recordings) {
  double out = 0.0;
  for (const Recording* r : recordings) {
    const auto found = r->file_units.find("gyr");
    const double unit = found == r->file_units.end() ? 1.0 : found->second;
    if (out != 0.0 && unit != out) return 0.0;
    out = unit;
  }
  return out;
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
  c.lever_arms = there.lever_arms;
  c.residuals = there.residuals;
  c.residual_series = residual_series(optimum, c.mag_names);
  mag_squares = held.mag_squares(optimum.rows, optimum.system.residual());
}

}  // namespace

Calibration calibrate(const Recording& recording, const CalibrationOptions& options) {
  return calibrate(std::vector<const Recording*>{&recording}, options);
}

namespace {

// The samples that were given, not the means of them that the fit was made of.
void take_over_rates(const std::vector<const Recording*>& given,
                     const std::vector<const Recording*>& used, int node_every, Calibration& c) {
  const auto in_one = [&](const VectorSeries& all, const VectorSeries& means) {
    return std::max(1.0, std::round(double(all.size()) / double(means.size())));
  };
  c.samples = 0;
  for (const Recording* r : given) c.samples += int(r->gyr.size());
  const Recording &first = *given.front(), &slower = *used.front();
  c.node_every = node_every * int(in_one(first.mag.front(), slower.mag.front()));
  c.acc_jitter *= in_one(first.acc, slower.acc);
}

// Noise of one reading of the first magnetometer at rest, uT; 0: not known.
double reading_at_rest(const Recording& recording, const NoiseDensities& rest) {
  return rest.mag * std::sqrt(recording.mag.front().rate_hz());
}

// What is wanted beside the calibration, where not null; and what was noticed.
struct Beside {
  std::optional<CondensedRecording>* condensed = nullptr;
  bool needs_optimum = false;         // a fit that finds none is of no use
  std::optional<BiasStep> step = {};  // where it is why the verdict is not yes
};

// Throws NumericalError where no fit can be made.
Calibration calibrate_checked(const CheckedRecordings& checked, const CalibrationOptions& options,
                              Mounting& mounting, Beside& beside) {
  std::optional<CondensedRecording>* const condensed = beside.condensed;
  // Who says which samples are a node gets these samples.
  const TurningRates rates(checked.get(), options);
  const SlowerRecordings slower(options.node_every > 0 ? std::vector<const Recording*>{}
                                                       : rates.get());
  const auto progress = [&](const std::string& what, double share) {
    if (options.progress) options.progress(what, share);
  };
  progress("which model?", 0.1);
  const std::vector<const Recording*>& used = options.node_every > 0 ? rates.get() : slower.get();
  std::optional<Beginning> begun;
  parallel::invoke([&] { begun.emplace(used, options); },
                   [&] { mounting = check_mounting(FewMagnetometers(used).get()); });
  progress("the fit, and what may be missing", 0.5);
  const std::vector<const Recording*>& recordings = begun->recordings();
  const FewMagnetometers& few = begun->few();
  const Pipeline& pipeline = begun->pipeline();
  const Stage& coarse = begun->coarse();
  if (beside.needs_optimum && !coarse.result().converged()) {
    throw NumericalError("the fit found no optimum");
  }
  Calibration c;
  std::vector<double> mag_squares;
  std::vector<Check> checks;
  SearchedEffects searched;
  std::vector<MissingEffect>& missing = searched.missing;
  int node_every = pipeline.node_every();
  std::optional<Stage> fine;
  std::optional<MissingEffect> lacking;
  const auto fit_finely = [&] {
    fine = pipeline.fine(coarse);
    if (!few.are_all()) {
      node_every = options.node_every > 0 ? options.node_every
                                          : array_node_every(*recordings.front(), node_every);
      fine = fit_all_magnetometers(recordings, *fine, node_every, options.optimizer,
                                   options.noise.has_value());
    }
    const Optimum optimum(*fine);
    MatrixXd moved;
    c = summarize(recordings, optimum, options, moved);
    if (condensed != nullptr) {
      *condensed = condense_optimum(optimum, int(c.mag_names.size()), c.covariance, moved);
    }
    c.residual_series = residual_series(optimum, c.mag_names);
    mag_squares = fine->mag_squares(optimum.rows, optimum.system.residual());
  };
  const auto predict = [&] { checks = pipeline.check_prediction(coarse); };
  const auto search = [&] {
    if (!coarse.result().converged()) return;
    if (auto seen = attempt([&] { return search_effects(few.get(), coarse); })) {
      searched = *std::move(seen);
    }
  };
  const auto find_lacking = [&] {
    if (!coarse.result().converged()) return;
    if (auto state = attempt([&] { return find_lacking_state(coarse); })) lacking = *state;
  };
  // fit_finely keeps its fit in memory. Of a long recording these run one after another, and it
  // comes last, when the memory of the others is free.
  side_by_side(coarse.plans(), predict, search, find_lacking, fit_finely);
  progress("the verdict", 0.95);
  c.motion_reason = begun->motion_reason();
  if (!rates.said().empty()) c.motion_reason += " " + rates.said();
  c.checks = checks;
  c.warnings = checked.warnings();
  take_over_rates(checked.get(), recordings, node_every, c);
  begun->add_doubt(c, condensed != nullptr && *condensed ? &**condensed : nullptr);
  widen_by_halves(c);
  std::vector<std::string> unknown = unknown_directions(c);
  if (coarse.result().converged() && few.are_all()) {
    if (auto bend = attempt([&] { return bent_posterior(c, coarse); }); bend && *bend) {
      add_bend(c, **bend);
    }
  }
  if (lacking) missing.push_back(*lacking);
  for (std::vector<MissingEffect>* effects : {&searched.missing, &searched.unseen}) {
    if (few.are_all()) break;
    for (MissingEffect& effect : *effects) {
      effect = of_all_magnetometers(effect, coarse.spec(), field_count(recordings), c);
    }
  }
  if (coarse.result().converged()) {
    add_missing_effects(c, missing);
    const MatrixXd more = add_unseen_tolerances(c, searched.unseen);
    if (condensed != nullptr && *condensed) {
      widen(**condensed, more);
      (*condensed)->common = more;
    }
  }
  add_prior(c, recordings, *fine, options, mag_squares);
  // An older calibration of the device may tell what this recording does not; what is usual may
  // not.
  if (options.prior == PriorKind::kGiven) unknown = unknown_directions(c);
  if (options.prior == PriorKind::kUsual) {
    for (std::string& reason : unknown) reason.insert(0, "By this recording alone: ");
  }
  for (const Recording* r : checked.get()) {
    c.blows_per_minute = std::max(c.blows_per_minute, blows_per_minute(*r));
  }
  c.disturbances = find_disturbances(c, mag_squares);
  const Check first[] = {check_optimum(c.fit), check_accuracy(c), check_whiteness(c),
                         check_windows(c, mag_squares)};
  c.checks.insert(c.checks.begin(), std::begin(first), std::end(first));
  const std::optional<BiasStep> step = step_of_magnetometer(searched);
  judge(c, unknown,
        {.cause = cause_of_misfit(c, missing),
         // Of what comes and goes only the rest of the recording shows whether it was that.
         .step = step && step->lasts() && step->beyond_chance ? sentence(*step) : "",
         .off_ellipsoid_uT = pipeline.guess().ellipsoid_rms_uT,
         .at_rest_uT = reading_at_rest(*recordings.front(), pipeline.rest_noise()),
         .gyr_unit = gyr_unit_of_files(recordings)});
  if (c.trust.verdict != Verdict::kYes) beside.step = step;
  judge_magnetometers(c);
  begun->add_lag(c);
  return c;
}

}  // namespace

namespace {

Calibration calibrate_judged(const std::vector<const Recording*>& given,
                             const CalibrationOptions& options, Beside& beside) {
  const auto start = std::chrono::steady_clock::now();
  const CheckedRecordings checked(given);
  Mounting mounting;
  std::string why;
  std::optional<Calibration> made =
      attempt([&] { return calibrate_checked(checked, options, mounting, beside); }, &why);
  Calibration c = made ? *std::move(made)
                       : calibration_without_fit(checked.get(), options, why, checked.warnings());
  judge_given_noise(c, checked.get(), options);
  judge_axes(c, mounting, options);
  judge_faults(c.trust, checked.faults());
  c.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return c;
}

// Throws std::invalid_argument: what no data could make up for.
void require_sound(const CalibrationOptions& options) {
  if (options.prior == PriorKind::kGiven && options.given_prior == nullptr) {
    throw std::invalid_argument("CalibrationOptions: prior is kGiven, so given_prior must be set");
  }
  if (!(options.gravity > 0.0) || !std::isfinite(options.gravity)) {
    throw std::invalid_argument("CalibrationOptions: gravity must be positive, in m/s^2");
  }
  if (options.noise) {
    for (const double density : {options.noise->acc, options.noise->gyr, options.noise->mag}) {
      if (density > 0.0 && std::isfinite(density)) continue;
      throw std::invalid_argument("CalibrationOptions: noise densities must be positive numbers");
    }
  }
  if (!(options.block_s > 0.0)) {
    throw std::invalid_argument("CalibrationOptions: block_s must be positive, in seconds");
  }
  if (options.node_every < 0) {
    throw std::invalid_argument("CalibrationOptions: node_every must not be negative");
  }
}

Calibration calibrate_anyhow(const std::vector<const Recording*>& given,
                             const CalibrationOptions& options, Beside& beside) {
  require_sound(options);
  const WellFormed recordings(given);
  try {
    return calibrate_judged(recordings.get(), options, beside);
  } catch (const TooLittle& too_little) {
    return calibration_without_fit(recordings.get(), options, too_little);
  }
}

constexpr int kMostSteps = 3;  // in one recording

// Without what was measured before a change that lasts, for the device is what it was last; without
// the magnetometers' readings of a time in which they were otherwise.
Recording without_step(const Recording& given, const BiasStep& step) {
  if (step.lasts()) return slice(given, step.begin_s + step.within_s, step.end_s);
  Recording out = given;
  for (VectorSeries& mag : out.mag) {
    VectorSeries outside;
    for (std::size_t k = 0; k < mag.size(); ++k) {
      const bool inside =
          mag.t[k] > step.begin_s - step.within_s && mag.t[k] < step.end_s + step.within_s;
      if (!inside) outside.push_back(mag.t[k], mag.v[k]);
    }
    mag = std::move(outside);
  }
  return out;
}

// The calibration of what is left without that step, and without another that shows then, where
// that tells more than all samples do.
Calibration beside_steps(const Recording& given, const CalibrationOptions& options, BiasStep step,
                         Calibration all) {
  std::vector<std::string> said;
  Recording left = given;
  for (int steps = 0; steps < kMostSteps; ++steps) {
    left = without_step(left, step);
    if (left.gyr.empty() || left.mag.front().empty()) break;
    said.push_back(sentence(step) +
                   (step.lasts() ? " The calibration is the one that holds since then."
                                 : " The calibration is made without its readings of that time."));
    Beside beside{.needs_optimum = true};
    Calibration out;
    try {
      out = calibrate_anyhow({&left}, options, beside);
    } catch (const InputError&) {
      break;
    }
    if (out.trust.verdict < all.trust.verdict) {  // the better one
      out.warnings.insert(out.warnings.begin(), said.begin(), said.end());
      out.seconds += all.seconds;
      return out;
    }
    if (!beside.step) break;
    step = *beside.step;
  }
  return all;
}

}  // namespace

Calibration calibrate(const std::vector<const Recording*>& given,
                      const CalibrationOptions& options) {
  Beside beside;
  Calibration c = calibrate_anyhow(given, options, beside);
  if (!beside.step || given.size() != 1) return c;
  return beside_steps(*given.front(), options, *beside.step, std::move(c));
}

Calibration calibrate_whole(const std::vector<const Recording*>& given,
                            const CalibrationOptions& options) {
  Beside beside;
  return calibrate_anyhow(given, options, beside);
}

Calibration calibrate_condensed(const Recording& recording, const CalibrationOptions& options,
                                std::optional<CondensedRecording>& condensed) {
  condensed.reset();
  Beside beside{.condensed = &condensed};
  return calibrate_anyhow({&recording}, options, beside);
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "calibration/array_fit.h"
#include "calibration/calibrate_whole.h"
#include "calibration/fit/given_noise.h"
#include "calibration/fit/side_by_side.h"
#include "calibration/scan/missing_effects.h"
#include "calibration/start/turned_axes.h"
#include "calibration/travelling.h"
#include "calibration/trust/check_axes.h"
#include "calibration/trust/no_fit.h"
#include "calibration/trust/trust.h"
#include "calibration/turning_rates.h"
#include "diagnosis/compare/against.h"
#include "diagnosis/compare/predict.h"
#include "diagnosis/conclude/array_coupling.h"
#include "diagnosis/conclude/conclude.h"
#include "diagnosis/conclude/contradictions.h"
#include "diagnosis/conclude/cut_rests.h"
#include "diagnosis/conclude/departures.h"
#include "diagnosis/conclude/missing_state.h"
#include "diagnosis/conclude/next_step.h"
#include "diagnosis/conclude/noise_findings.h"
#include "diagnosis/conclude/place.h"
#include "diagnosis/conclude/unexplained.h"
#include "diagnosis/held/held_model.h"
#include "diagnosis/noise/thinned.h"
#include "diagnosis/result/diagnosis.h"
#include "diagnosis/result/sentence_words.h"
#include "diagnosis/search/extender.h"
#include "diagnosis/search/motion_finding.h"
#include "diagnosis/search/passing_source.h"
#include "graph/numerical_error.h"
#include "recording/data/error.h"
#include "recording/data/well_formed.h"

namespace magimu {
namespace {

// Did the sensor turn about more than one axis, by more than a few degrees?
bool has_turned(const Stage& stage) {
  std::vector<Rot3> nRb;
  for (const NodePlan& plan : stage.plans()) {
    for (std::size_t k = 0; k < plan.t.size(); ++k) {
      nRb.push_back(stage.result().values.at<Rot3>(R(plan.first + int(k))));
    }
  }
  return turned_axes(nRb).enough;
}

int samples_of(const std::vector<const Recording*>& recordings) {
  int n = 0;
  for (const Recording* r : recordings) n += int(r->gyr.size());
  return n;
}

void take_conclusion(Diagnosis& d) {
  Conclusion conclusion = conclude(d);
  d.answer = conclusion.answer;
  d.evidence = std::move(conclusion.evidence);
  d.unexplained = std::move(conclusion.unexplained);
  d.next_step = next_step(d);
}

CalibrationOptions calibration_options(const DiagnosisOptions& options) {
  CalibrationOptions out;
  out.noise = options.noise;
  out.gravity = options.gravity;
  return out;
}

// The verdict's: as `magimu calibrate` is asked, of the motion that was given.
CalibrationOptions verdict_options(const DiagnosisOptions& options) {
  CalibrationOptions out = calibration_options(options);
  out.motion = options.base ? options.base->motion : options.motion;
  if (!options.base) return out;
  for (const ActiveEffect& effect : options.base->effects) {
    if (effect.name == "mag_time_offset") out.mag_time_offset = true;
    if (effect.name == "gyro_scale_misalignment") out.gyr_matrix = true;
  }
  return out;
}

// That of the model with the causes that were found. Where there are none, a calibration by that
// model is the one that calibrate() makes.
void judge_after(const CheckedRecordings& checked, const Mounting& mounting,
                 const CalibrationOptions& calibration, const DiagnosisOptions& options,
                 Diagnosis& d) {
  Calibration& c = d.after;
  if (options.calibrate_before && d.findings.empty() && c.fit.converged()) {
    c.trust = d.before.trust;
    return;
  }
  c.blows_per_minute = d.before.blows_per_minute;
  judge(c);
  judge_given_noise(c, checked.get(), calibration);
  judge_axes(c, mounting, calibration);
  judge_faults(c.trust, checked.faults());
}

std::string who_was_asked(const std::vector<std::string>& names) {
  return fmt::format(
      "Of {} magnetometers {} to {} were asked what is missing, and all whether they carry on to "
      "each other what they read. The first ones of a recording are asked "
      "(`--magnetometer NAME` puts another one first); a calibration judges each of them.",
      names.size(), names.front(), names[kFewMagnetometers - 1]);
}

// The diagnosis where there is no model to begin with: only the verdict.
Diagnosis diagnosis_of(const Calibration& before, Calibration after,
                       const std::vector<const Recording*>& given,
                       const DiagnosisOptions& options) {
  Diagnosis d;
  d.false_alarm_rate = options.false_alarm_rate;
  for (const Recording* r : given) d.recordings.push_back(r->name);
  d.notes = before.warnings;
  d.before = before;
  d.after = std::move(after);
  take_conclusion(d);
  return d;
}

// The basic model has no fit.
Diagnosis diagnosis_without_fit(const std::vector<const Recording*>& given,
                                const DiagnosisOptions& options, const std::string& why) {
  const CheckedRecordings checked(given);
  return diagnosis_of(
      calibrate_whole(given, verdict_options(options)),
      calibration_without_fit(checked.get(), calibration_options(options), why, checked.warnings()),
      given, options);
}

// Findings of times, one of which may be withdrawn by what the others came to.
bool have_times(const Diagnosis& d) {
  const auto found = [&](const char* effect) {
    return std::ranges::count(d.findings, effect, &Finding::effect) > 0;
  };
  return (found("mag_time_offset") && found("acc_time_offset")) ||
         (found("mag_bandwidth") && found("mag_own_clock"));
}

struct Diagnosed {
  Diagnosis diagnosis;
  // Where the sensor may have travelled: how far away a hand would have held it (reach_in_words()),
  // and the finding that it was moved. Else empty.
  std::string beyond_reach = {};
  std::optional<Finding> moved = {};
};

// With the causes that were found, is a hand still beyond its reach? Of a sensor that only turned
// something must be left instead, and calibrate() must take it to travel, too. What lies in another
// sensor does not come from travel, and an accelerometer that is at fault looks like it. Its noise
// is no fault: what travel leaves passes for noise that is coloured.
bool may_have_travelled(const Diagnosis& d, const Extender& extender) {
  const std::string acc = to_string(Sensor::kAcc);
  const MissingState* const missing = most_missing(d);
  if (missing != nullptr && missing->channel != acc) return false;
  const bool at_fault = std::ranges::any_of(d.findings, [&](const Finding& f) {
    return f.channel == acc && f.effect != "linear_acceleration" && find_effect(f.effect);
  });
  if (at_fault || extender.may_have_changed(Sensor::kAcc)) return false;
  if (extender.stage().spec().motion == MotionModel::kHandHeld) {
    return is_beyond_reach(extender.stage());
  }
  return missing != nullptr && d.before.motion == MotionModel::kTravelling;
}

// Throws NumericalError where the basic model has no fit.
Diagnosed diagnose_fitted(const std::vector<const Recording*>& given,
                          const DiagnosisOptions& given_options) {
  DiagnosisOptions options = given_options;
  if (options.base && options.base->noise_given && !options.noise) {
    options.noise = options.base->noise;
  }
  const auto start = std::chrono::steady_clock::now();
  const auto progress = [&](const std::string& what, double share) {
    if (options.progress) options.progress(what, share);
  };
  for (const Recording* r : given) refuse_mostly_set_aside(*r);
  const CheckedRecordings checked(given, {.keep_clipped_mag = true});
  const CalibrationOptions calibration = calibration_options(options);
  Diagnosis d;
  d.false_alarm_rate = options.false_alarm_rate;
  for (const Recording* r : given) d.recordings.push_back(r->name);
  d.notes = checked.warnings();
  const FewMagnetometers few(checked.get());
  if (!few.are_all()) d.notes.push_back(who_was_asked(checked.get().front()->mag_names));

  // Where the axes of accelerometer and gyroscope disagree no model fits, and every effect is seen.
  const Mounting mounting = check_mounting(few.get());
  for (const AxesFinding& f : mounting.findings) {
    if (f.sensor != "acc" && f.sensor != "gyr") continue;
    const Calibration verdict = calibrate_whole(given, verdict_options(options));
    return {diagnosis_of(verdict, verdict, given, options)};
  }

  progress("fitting the basic model", 0.0);
  std::vector<Recording> used, thin;
  const TurningRates rates(few.get(), calibration);
  if (!rates.said().empty()) d.notes.push_back(rates.said());
  for (const Recording* r : rates.get()) used.push_back(without_long_rests(*r, d.notes));
  take_out_saturated(used, options, d);
  for (const Recording& r : used) thin.push_back(thinned(r));
  std::vector<const Recording*> recordings, full;
  for (const Recording& r : used) full.push_back(&r);
  for (const Recording& r : thin) recordings.push_back(&r);
  const Pipeline pipeline(recordings, calibration);
  Extender extender(recordings, few.get(), pipeline, options, d);
  progress("is it the motion?", 0.15);
  const ChosenMotion motion = choose_motion_model(recordings, pipeline, options, extender, d);
  Stage first = motion.stage;
  const auto find_causes = [&] {
    progress("looking for effects", 0.3);
    const bool turned = has_turned(first);
    if (turned) {
      extender.extend(first);
      if (withdraw_motion(recordings, pipeline, extender, d)) first = extender.base();
      if (!options.base && options.motion == MotionModel::kAuto) {
        if (auto moving = find_small_motion(recordings, pipeline, extender, d)) first = *moving;
      }
    } else {
      extender.replace(first);
      d.notes.push_back(
          "The sensor hardly turned, so that almost no cause can be told from the calibration "
          "itself: "
          "turn it about all three of its axes, by half a turn and more.");
      for (const auto& effect : effect_catalogue()) {
        if (effect->name() == "mag_coupling" && recordings.front()->mag.size() < 2) continue;
        d.scan.push_back({.effect = effect->name(),
                          .channel = to_string(effect->channel()),
                          .needs = kHardlyTurned});
      }
    }
    const PassingSource passing =
        turned ? find_passing_source(recordings, extender.stage()) : PassingSource{};
    if (passing.finding) d.findings.push_back(*passing.finding);
    progress("looking at the noise", 0.7);
    find_noise(full, pipeline, options, turned, extender, d);
    if (turned) {
      find_array_coupling(checked.get(), recordings, extender.stage(), pipeline.node_every(),
                          options, d);
    }
    progress("what is left?", 0.85);
    Dependences dependences;
    if (turned) dependences = find_unexplained(recordings, full, options, extender, d);
    if (!passing.evidence.empty()) add_evidence(d, passing.channel, passing.evidence);
    withdraw_other_lines(few.get(), d);
    // By their values beside all that was found.
    if (have_times(d)) extender.restate(extender.summary(extender.stage()));
    withdraw_contradicted(given, d);
    name_dead_band(given, d);
    extender.keep_named();
    find_repeats(given, d);
    const int at_rest = find_changes_in_cut_rests(few.get(), full, extender.stage(), d);
    progress("how wrong, where, when?", 0.87);
    d.off_ellipsoid_uT = pipeline.guess().ellipsoid_rms_uT;
    const auto place = find_missing_state(
        {recordings, full, first, extender.stage(), {.mag_noise_known = options.noise.has_value()}},
        d);
    if (place != nullptr) {
      if (const auto placed = model_with_place(pipeline, extender.stage(), *place)) {
        extender.replace(*placed);
        dependences.left = unexplained_beside(recordings, full, options, extender, d);
      }
    }
    withdraw_crumbs_of_noise(d);
    add_unexplained(std::move(dependences), d);
    fill_departures(recordings, full, extender, pipeline.rest_noise(), options.noise.has_value(),
                    at_rest, d);
    d.after = extender.summary(extender.stage());
    // A cause that was named takes what others of its kind look like, and is no surer than they
    // are.
    if (const auto unseen = attempt([&] { return search_unseen(recordings, extender.stage()); })) {
      add_unseen_tolerances(d.after, *unseen);
    }
    extender.restate(d.after);
    restate_motion(extender.stage(), d);
    reword_by_what_is_known(given, d);
    tell_shares_taken(d);
  };
  // It knows nothing of the causes, and so need not wait for them.
  std::optional<Calibration> verdict;
  const auto calibrate_beside = [&] {
    if (options.calibrate_before) verdict = calibrate_whole(given, verdict_options(options));
  };
  side_by_side(first.plans(), find_causes, calibrate_beside);
  progress("may the calibration be trusted?", 0.9);
  if (options.calibrate_before) {
    d.before = *std::move(verdict);
    if (d.before.motion == MotionModel::kTravelling &&
        extender.stage().spec().motion != MotionModel::kTravelling) {
      d.notes.push_back(
          d.before.motion_reason +
          " This diagnosis takes it to have stayed in reach; --motion travelling asks for causes "
          "beside a sensor that travelled.");
    }
  } else {
    d.before = extender.summary(extender.base());
    judge(d.before);
    d.before.samples = samples_of(full);
  }
  judge_after(checked, mounting, calibration, options, d);
  // The samples themselves, not the means of them that the fits were made of.
  d.after.samples = samples_of(full);
  d.model_before = extended_model(extender.base(), {});
  d.model_motion = first.spec().effects.size() > extender.base().spec().effects.size()
                       ? d.model_before
                       : extended_model(first, {});
  d.model_after = extended_model(extender.stage(), d.findings);
  if (may_predict(d) && extender.stage().spec().effects.empty()) {
    progress("do halves agree?", 0.93);
    if (const auto halves = pipeline.halves(extender.stage())) d.after.checks.push_back(*halves);
  }
  take_conclusion(d);
  if (d.answer == Answer::kUnexplained || d.answer == Answer::kPartly) {
    d.after.trust.lower(Verdict::kLimited, what_sigmas_know(d));
  }
  if (options.against) {
    progress("comparing with the stored calibration", 0.95);
    d.against =
        compare_with(*options.against, options.against_name, given,
                     {.noise = options.noise, .false_alarm_rate = options.false_alarm_rate});
    compare_beside_causes(*options.against, given, d, *d.against);
  }
  d.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  progress("done", 1.0);
  if (!motion.moved || !may_have_travelled(d, extender)) return {std::move(d)};
  const Stage& last = extender.stage();
  const bool held = last.spec().motion == MotionModel::kHandHeld;
  return {std::move(d), held ? reach_in_words(last) : motion.beyond_reach, motion.moved};
}

// Where the sensor may have travelled, that is diagnosed, too. It is taken where only crumbs of
// what was missing are left.
Diagnosis diagnose_motion(const std::vector<const Recording*>& given,
                          const DiagnosisOptions& options) {
  Diagnosed first = diagnose_fitted(given, options);
  if (!first.moved) return std::move(first.diagnosis);
  DiagnosisOptions asked = options;
  asked.motion = MotionModel::kTravelling;
  if (options.progress) {
    asked.progress = [&](const std::string& what, double share) {
      options.progress("did it travel? " + what, share);
    };
  }
  auto made = attempt([&] { return diagnose_fitted(given, asked).diagnosis; });
  if (!made || !made->after.fit.converged()) return std::move(first.diagnosis);
  Diagnosis& travelled = *made;
  const double before = nats_left(first.diagnosis), left = nats_left(travelled);
  if (left > kCrumb * before) return std::move(first.diagnosis);
  Finding& moved = *first.moved;
  moved.sentence = fmt::format(
      "The sensor travelled: it accelerated by {:.2g} m/s^2 (RMS), and a hand would have held it "
      "{}. Velocity and position are part of the model, with {:.2g} m/s (a standard deviation) "
      "wherever that leads{}.",
      moved.parameters.front().value, first.beyond_reach, travelled.after.speed_mps,
      left < before
          ? fmt::format("; a hand leaves {:.0f} nats unexplained, this {:.0f}", before, left)
          : "");
  moved.gain.residual_rms_after = travelled.after.residuals[std::size_t(Sensor::kAcc)].rms;
  travelled.seconds += first.diagnosis.seconds;
  // What was missing before it was known that the sensor travelled is missing before any cause.
  for (MissingState& m : travelled.missing) {
    for (const MissingState& was : first.diagnosis.missing) {
      if (was.channel == m.channel && was.frame == m.frame) m.gain_nats = was.gain_nats;
    }
  }
  travelled.findings.insert(travelled.findings.begin(), moved);
  take_conclusion(travelled);
  return std::move(travelled);
}

}  // namespace

Diagnosis diagnose(const Recording& recording, const DiagnosisOptions& options) {
  return diagnose(std::vector<const Recording*>{&recording}, options);
}

Diagnosis diagnose(const std::vector<const Recording*>& recordings,
                   const DiagnosisOptions& options) {
  const WellFormed well_formed(recordings);
  const std::vector<const Recording*>& given = well_formed.get();
  try {
    std::string why;
    std::optional<Diagnosis> made = attempt([&] { return diagnose_motion(given, options); }, &why);
    return made ? *std::move(made) : diagnosis_without_fit(given, options, why);
  } catch (const TooLittle& too_little) {
    const Calibration none =
        calibration_without_fit(given, calibration_options(options), too_little);
    return diagnosis_of(none, none, given, options);
  }
}

}  // namespace magimu

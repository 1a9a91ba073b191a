// SPDX-License-Identifier: BSD-3-Clause
// The end of a stream: what calibrate() makes of the same samples, but for those that did not fit
// the rest; where the magnetometer's bias changed, of those since then. Where these do not tell
// enough, or where there are too many samples, it is the stream's own estimate, judged by the same
// checks.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "calibration/fit/diagnostics.h"
#include "calibration/fit/held_out.h"
#include "calibration/fit/parameter_prior.h"
#include "calibration/fit/summary.h"
#include "calibration/live/stream_state.h"
#include "calibration/motion/blows.h"
#include "calibration/scan/missing_effects.h"
#include "calibration/trust/check_axes.h"
#include "calibration/trust/disturbances.h"
#include "calibration/trust/no_fit.h"
#include "calibration/trust/trust.h"
#include "graph/numerical_error.h"
#include "recording/checks/gate.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

// Samples that are looked at if nothing could be estimated: 10 minutes at 200 Hz.
constexpr std::size_t kLastSamples = 120000;
// Before the target is called met, again and again: the samples are then so many times as long.
constexpr double kAskedAgain = 1.25;

}  // namespace

// The options with which a user would call calibrate().
CalibrationOptions StreamingCalibration::State::final_options() const {
  CalibrationOptions options = batch_;
  options.motion = options_.motion;
  options.node_every = 0;
  return options;
}

Calibration StreamingCalibration::State::calibrate_as_kept(const Recording& raw) const {
  return calibrate(flagged_.empty() ? raw : without_flagged(raw), final_options());
}

// The estimate of the stream knows nothing of what the motion so far cannot show: errors that parts
// have as a rule, a model that something is missing in. calibrate() does, and so it is asked, where
// the samples are kept as they came, before anybody is told to stop.
bool StreamingCalibration::State::is_good_enough() {
  const Recording* const raw = samples_.raw();
  if (borne_out_ || raw == nullptr || !changes_.empty()) return true;
  const double length = samples_.last_t() - samples_.first_t();
  if (length < next_asked_) return false;
  next_asked_ = kAskedAgain * length;
  try {
    const Calibration c = calibrate_as_kept(*raw);
    borne_out_ = c.trust.verdict != Verdict::kNo && distance(c) <= 1.0;
    not_yet_ = c.trust.reasons.empty() ? "" : c.trust.reasons.front();
  } catch (const InputError& error) {
    not_yet_ = error.problem;
  } catch (const NumericalError& error) {
    not_yet_ = error.what();
  }
  return borne_out_;
}

// Without the magnetometers' samples in windows that were left out.
Recording StreamingCalibration::State::without_flagged(const Recording& raw) const {
  Recording out = gated(raw).value_or(raw);
  for (std::size_t m = 0; m < out.mag.size(); ++m) {
    const VectorSeries all = std::exchange(out.mag[m], {});
    SetAside gone{out.mag_names[m], "disturbed", 0, all.size(), 0.0, 0.0, ""};
    std::vector<int>::const_iterator window = flagged_.begin();
    for (std::size_t k = 0; k < all.size(); ++k) {
      while (window != flagged_.end() && all.t[k] >= end_of(*window)) ++window;
      if (window == flagged_.end() || all.t[k] < begin_of(*window)) {
        out.mag[m].push_back(all.t[k], all.v[k]);
        continue;
      }
      if (gone.count++ == 0) {
        gone.begin_s = all.t[k];
        gone.example = fmt::format("the first at {:.2f} s", all.t[k]);
      }
      gone.end_s = all.t[k];
    }
    if (gone.count > 0) out.set_aside.push_back(gone);
  }
  return out;
}

// Of the samples since the last change alone: whatever it was, another sensor's perhaps, they are
// those of the device as it is now. Nothing where they do not tell enough. (What did not fit before
// may fit then.)
std::optional<Calibration> StreamingCalibration::State::calibrate_since_change(
    const Recording& raw) const {
  const auto since = [&](const Recording& all) -> std::optional<Calibration> {
    const Recording last =
        slice(all, end_of(changes_.back()), std::numeric_limits<double>::infinity());
    if (last.gyr.empty() || last.mag.front().empty()) return std::nullopt;
    try {
      Calibration c = calibrate(last, final_options());
      if (c.trust.verdict != Verdict::kYes) return std::nullopt;
      c.warnings.insert(c.warnings.begin(), warnings_.begin(), warnings_.end());
      return c;
    } catch (const InputError&) {
      return std::nullopt;
    }
  };
  std::optional<Calibration> c = since(raw);
  return c || flagged_.empty() ? c : since(without_flagged(raw));
}

Calibration StreamingCalibration::State::finish() {
  Calibration c = finish_as_asked();
  // What whoever watched was told, whoever reads the file must know.
  if (changed_) c.warnings.push_back(sentence(*changed_, samples_.all().mag_names));
  return c;
}

Calibration StreamingCalibration::State::finish_as_asked() {
  samples_.finish();
  if (estimator_) take_windows();
  const Recording* const raw = samples_.raw();
  const bool is_long = samples_.node_t().size() > std::size_t(options_.long_stream);
  if (!estimator_) {
    // A fit of hours would need gigabytes; the last samples show as well what is missing.
    const Recording& all = samples_.all();
    const std::vector<double>& t = all.gyr.empty() ? all.mag.front().t : all.gyr.t;
    if (raw != nullptr || t.size() <= kLastSamples) {
      return calibrate(raw != nullptr ? *raw : all, final_options());
    }
    return calibrate(slice(all, t[t.size() - kLastSamples], t.back()), final_options());
  }
  if (raw != nullptr && changes_.empty() && !is_long) {
    return calibrate_as_kept(*raw);
  }
  if (raw != nullptr && !is_long) {
    if (std::optional<Calibration> since = calibrate_since_change(*raw)) return *std::move(since);
  }
  std::optional<CheckedRecordings> checked;
  if (raw != nullptr) checked.emplace(std::vector<const Recording*>{raw});
  std::string why;
  std::optional<Calibration> made = attempt(
      [&] { return is_long ? finish_long() : finish(samples_.parts(estimator_->windows())); },
      &why);
  Calibration c =
      made ? *std::move(made) : calibration_without_fit({&samples_.all()}, batch_, why, warnings_);
  if (checked) {
    c.warnings.insert(c.warnings.end(), checked->warnings().begin(), checked->warnings().end());
    judge_faults(c.trust, checked->faults());
  }
  return c;
}

// What a calibration says of the stream, whatever the fit.
void StreamingCalibration::State::describe_stream(
    Calibration& c, const std::vector<const Recording*>& recordings) const {
  c.node_every = samples_.every();
  c.warnings = warnings_;
  if (options_.motion == MotionModel::kAuto) {
    c.motion_reason =
        "A stream takes the sensor to be moved by a hand, within its reach: where it only turns, "
        "that costs next to nothing.";
  }
  for (const Recording* recording : recordings) {
    c.blows_per_minute = std::max(c.blows_per_minute, blows_per_minute(*recording));
  }
}

Calibration StreamingCalibration::State::finish(const StreamParts& parts) {
  const std::vector<const Recording*> recordings = parts.pointers();
  settle();
  ModelSpec spec = spec_;
  spec.without_mag = left_out();
  Stage stage(recordings, spec, parts.plans, batch_.optimizer);
  stage.fit(estimator_->estimate(), true);
  Calibration c = summarize(recordings, stage, batch_);
  describe_stream(c, recordings);
  const std::vector<double> squares = stage.mag_squares();
  c.disturbances = find_disturbances(c, squares);
  c.checks = {check_optimum(c.fit), check_accuracy(c), check_whiteness(c),
              check_windows(c, squares)};
  std::vector<std::string> unknown;
  if (c.fit.converged() && c.undetermined.empty()) {
    c.checks.push_back(check_held_out(block_errors(stage), c.strength_uT));
    unknown = unknown_directions(c);
    if (changes_.empty()) {
      const SearchedEffects searched = search_effects(recordings, stage);
      add_missing_effects(c, searched.missing);
      add_unseen_tolerances(c, searched.unseen);
    }
    take_known_beforehand(c, batch_);
  }
  judge(c, unknown);
  judge_axes(c, check_mounting(recordings), batch_);
  return c;
}

}  // namespace magimu

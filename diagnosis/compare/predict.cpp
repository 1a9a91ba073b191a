// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/compare/predict.h"

#include <algorithm>
#include <cmath>

#include "calibration/model/extension.h"
#include "calibration/pipeline.h"
#include "calibration/scan/change_search.h"
#include "calibration/turning_rates.h"
#include "diagnosis/held/held_model.h"
#include "diagnosis/noise/noise_tests.h"
#include "diagnosis/noise/sample_residuals.h"
#include "diagnosis/noise/thinned.h"
#include "diagnosis/search/option.h"
#include "factors/effects/catalogue.h"

namespace magimu {
namespace {

bool begins_or_ends(const KnownEffect& k) { return is_change(k.effect->name()); }

// The form of a change whose prior was replaced (with_prior), by its parameters.
ChangeForm form_of(const Effect& change) {
  for (const ChangeForm form : forms_of_change(change.name())) {
    const auto same = make_change(change.name(), form, {});
    if (same->size() == change.size() && same->description().parameters.front().name ==
                                             change.description().parameters.front().name) {
      return form;
    }
  }
  return forms_of_change(change.name()).front();
}

// The likelihood of one recording under one model.
class Predictor {
 public:
  // recordings: one, or its parts, thinned; full: the same with all samples.
  Predictor(const std::vector<const Recording*>& recordings,
            const std::vector<const Recording*>& full, const ExtendedModel& model, bool mag_only)
      : recordings_(recordings),
        full_(full),
        model_(model),
        mag_only_(mag_only),
        options_(options_of(model)),
        pipeline_(recordings, options_),
        own_(pipeline_.with_fixed_symmetries(pipeline_.coarse_fit(model.spec.motion))) {}

  double nll() const {
    std::vector<KnownEffect> device, all, changes;
    for (const KnownEffect& k : known_effects(model_)) {
      if (k.held) device.push_back(k);
      (begins_or_ends(k) ? changes : all).push_back(k);
    }
    const Fit plain = fit(device);
    if (all.size() == device.size() && changes.empty()) return plain.nll + noise_gain(plain.stage);
    Fit with = all.size() == device.size() ? plain : fit(all);
    for (const KnownEffect& change : changes) with = with_change(change, all, with);
    // The surroundings are as they were, or are not: even odds.
    const double least = std::min(plain.nll, with.nll);
    const double mixed =
        least - std::log(0.5 * (std::exp(least - plain.nll) + std::exp(least - with.nll)));
    return mixed + noise_gain(plain.nll < with.nll ? plain.stage : with.stage);
  }

 private:
  struct Fit {
    Stage stage;
    double nll;
  };

  static CalibrationOptions options_of(const ExtendedModel& model) {
    CalibrationOptions options;
    options.noise = model.spec.noise;
    options.gravity = model.spec.gravity;
    return options;
  }

  Fit fit(const std::vector<KnownEffect>& effects) const {
    ModelSpec spec = model_.spec;
    spec.reach_m = own_.spec().reach_m;
    spec.speed_mps = own_.spec().speed_mps;
    spec.velocity_every_s = own_.spec().velocity_every_s;
    Stage stage(recordings_, spec, pipeline_.coarse_every(), {});
    Values start = carry_over(recordings_, own_, stage);
    const std::vector<Integrated> free =
        hold(model_, effects, recordings_.front()->duration_s(), spec, start);
    const auto fitted = [&] {
      Stage s(recordings_, spec, pipeline_.coarse_every(), {});
      s.fit(start, true);
      return s;
    };
    stage = fitted();
    double nll = laplace_nll(stage, free);
    if (mag_only_) {
      spec.without_mag = [](int) { return true; };
      nll -= laplace_nll(fitted(), free);
    }
    return {std::move(stage), nll};
  }

  // The change at the times at which this recording shows it, added to `effects`.
  Fit with_change(const KnownEffect& change, std::vector<KnownEffect>& effects,
                  const Fit& without) const {
    const std::string& name = change.effect->name();
    const std::vector<LikelyChange> likely = likely_changes(recordings_, without.stage, {name});
    if (likely.empty()) return without;
    const LikelyChange& first =
        *std::ranges::min_element(likely, {}, [](const LikelyChange& c) { return c.log10_p(); });
    // In the form in which it was found elsewhere, and as large as there.
    const ChangeForm form = form_of(*change.effect);
    const VectorXd size = change.effect->prior_sigma(0.0);
    effects.push_back({nullptr, VectorXd::Zero(size.size()), false});
    const auto between = [&](const ChangeTimes& times) {
      effects.back().effect = with_prior(make_change(name, form, times.span), size);
      return fit(effects);
    };
    const ChangeTimes coarse = {.span = first.span};
    const auto any = make_change(name, form, {});
    const ChangeTimes times =
        refined_times(recordings_, between(coarse).stage, *as_change(*any), coarse,
                      [&](const ChangeTimes& t) { return between(t).stage; });
    Fit out = between(times);
    out.nll += cost_of_times(times, recordings_);
    return out;
  }

  // The gain in this recording, in nats, of the causes that were found in the noise.
  double noise_gain(const Stage& stage) const {
    if (model_.noise.empty()) return 0.0;
    const bool scale = std::any_of(model_.noise.begin(), model_.noise.end(),
                                   [](const auto& n) { return n.effect == "noise_scale"; });
    double gain = 0.0;
    for (std::size_t i = 0; i < full_.size(); ++i) {
      for (const NoiseTest& test :
           test_noise(sample_residuals(*full_[i], stage, int(i), model_.spec.noise, scale))) {
        for (const ExtendedModel::NoiseCause& cause : model_.noise) {
          if (cause.effect != test.effect || cause.channel != to_string(test.channel)) continue;
          if (test.untested.empty()) gain += test.nll_after - test.nll_before;
        }
      }
    }
    return gain;
  }

  const std::vector<const Recording*>& recordings_;
  const std::vector<const Recording*>& full_;
  const ExtendedModel& model_;
  bool mag_only_;
  CalibrationOptions options_;
  Pipeline pipeline_;
  Stage own_;
};

}  // namespace

ExtendedModel extended_model(const Stage& stage, const std::vector<Finding>& findings) {
  ExtendedModel model;
  model.spec = stage.spec();
  model.spec.extended.clear();
  const Values& values = stage.result().values;
  for (const Values::Slot& s : values.slots()) {
    const char c = s.key.symbol;
    if (c == R(0).symbol || c == V(0).symbol || c == P(0).symbol) continue;
    model.parameters.insert_from(values, s.key);
  }
  for (const Finding& f : findings) {
    const bool modelled =
        f.effect == "linear_acceleration" ||
        std::any_of(model.spec.effects.begin(), model.spec.effects.end(),
                    [&](const auto& effect) { return effect->name() == f.effect; });
    if (!modelled) model.noise.push_back({f.effect, f.channel});
  }
  return model;
}

PredictionGain compare_predictions(const Recording& recording, const ExtendedModel& before,
                                   const ExtendedModel& after) {
  const CheckedRecordings checked({&recording});
  CalibrationOptions options;
  options.noise = before.spec.noise;
  options.gravity = before.spec.gravity;
  const TurningRates rates(checked.get(), options);
  const std::vector<const Recording*>& full = rates.get();
  std::vector<Recording> thin;
  for (const Recording* part : full) thin.push_back(thinned(*part));
  std::vector<const Recording*> recordings;
  for (const Recording& part : thin) recordings.push_back(&part);
  PredictionGain out;
  out.mag_only = before.spec.motion != after.spec.motion;
  out.before = Predictor(recordings, full, before, out.mag_only).nll();
  out.after = Predictor(recordings, full, after, out.mag_only).nll();
  return out;
}

}  // namespace magimu

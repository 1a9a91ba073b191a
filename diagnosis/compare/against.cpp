// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/compare/against.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <optional>

#include "calibration/calibrate_whole.h"
#include "diagnosis/compare/calibration_difference.h"
#include "diagnosis/compare/change_text.h"
#include "diagnosis/held/held_model.h"
#include "diagnosis/result/sentence_words.h"
#include "factors/effects/change.h"
#include "graph/decompositions.h"
#include "recording/data/error.h"

namespace magimu {
namespace {

constexpr double kRobustBlock = 5.0;  // s, of the robust covariance

// d' C^-1 d, with C scaled to unit diagonal.
double wald(const VectorXd& d, const MatrixXd& C) {
  const VectorXd scale = C.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd unit = scale.asDiagonal() * C * scale.asDiagonal();
  const VectorXd z = d.cwiseProduct(scale);
  return z.dot(unit.ldlt().solve(z));
}

double p_white(double statistic, double dof) {
  return boost::math::cdf(
      boost::math::complement(boost::math::chi_squared(dof), std::max(0.0, statistic)));
}

double p_robust(double statistic, double dof, double blocks) {
  const double left = std::max(2.0, blocks - dof);
  const double f = std::max(0.0, statistic) * left / (dof * std::max(1.0, blocks - 1.0));
  return boost::math::cdf(boost::math::complement(boost::math::fisher_f(dof, left), f));
}

// The statistic that p_robust() gives this level.
double robust_critical(double level, double dof, double blocks) {
  const double left = std::max(2.0, blocks - dof);
  const double f =
      boost::math::quantile(boost::math::complement(boost::math::fisher_f(dof, left), level));
  return f * dof * std::max(1.0, blocks - 1.0) / left;
}

Change judged(const Difference& difference, int blocks, double level, double excess) {
  const auto dof = double(difference.d.size());
  Change c{.group = difference.group, .dof = int(difference.d.size()), .unit = difference.unit};
  const double white = wald(difference.d, difference.model) / excess;
  const double robust = wald(difference.d, difference.robust) / excess;
  const double pw = p_white(white, dof), pr = p_robust(robust, dof, blocks);
  c.p_value = std::max(pw, pr);
  c.statistic = pr >= pw ? robust : white;
  c.changed = c.p_value < level;
  // Both tests must see it; nine times out of ten they do at 1.28 sigmas more.
  const double white_critical =
      boost::math::quantile(boost::math::complement(boost::math::chi_squared(dof), level));
  const double of_white = std::sqrt(white_critical) + 1.28,
               of_robust = std::sqrt(robust_critical(level, dof, blocks)) + 1.28;
  for (Eigen::Index i = 0; i < difference.d.size(); ++i) {
    const double robust_sigma = std::sqrt(excess * difference.robust(i, i)),
                 white_sigma = std::sqrt(excess * difference.model(i, i));
    c.smallest = std::max({c.smallest, of_robust * robust_sigma, of_white * white_sigma});
    c.parameters.push_back({difference.names[std::size_t(i)], difference.d[i],
                            std::max(robust_sigma, white_sigma), difference.unit});
  }
  c.sentence = change_sentence(c);
  return c;
}

// How far the halves of the new recordings lie apart, as squares over what their covariances say:
// an error that persists for minutes makes it large, a change since the calibration was stored does
// not. Empty where halves cannot be calibrated.
Excess excess_of_halves(const std::vector<const Recording*>& recordings,
                        const CalibrationOptions& options) {
  std::vector<Calibration> halves;
  try {
    for (const bool second : {false, true}) {
      std::vector<Recording> parts;
      for (const Recording* r : recordings) {
        const double begin = r->gyr.t.front(), end = r->gyr.t.back(), mid = 0.5 * (begin + end);
        parts.push_back(second ? slice(*r, mid, end) : slice(*r, begin, mid));
      }
      std::vector<const Recording*> half;
      for (const Recording& part : parts) half.push_back(&part);
      halves.push_back(calibrate_whole(half, options));
      if (!halves.back().fit.converged() || !halves.back().undetermined.empty()) return {};
    }
  } catch (const InputError&) {
    return {};  // too short
  }
  Excess out;
  for (const Difference& d : differences(halves[0], halves[1])) {
    out[d.group] = wald(d.d, d.robust) / double(d.d.size());
  }
  return out;
}

int blocks_of(const std::vector<const Recording*>& recordings) {
  double duration = 0.0;
  for (const Recording* r : recordings) duration += r->duration_s();
  return std::max(1, int(duration / kRobustBlock));
}

// "from 30 s on until 35 s"
std::string when_changed(const Finding& f) {
  std::string out;
  for (const FoundParameter& p : f.parameters) {
    if (!std::isfinite(p.value)) continue;
    const char* const blank = out.empty() ? "" : " ";
    if (p.name == "t0") out += fmt::format("{}from {:.5g} s on", blank, p.value);
    if (p.name == "t1") out += fmt::format("{}until {:.5g} s", blank, p.value);
  }
  return out;
}

// The calibration while a change of a bias lasts; nothing of other changes.
std::optional<Calibration> while_it_lasts(const Calibration& outside, const Finding& f) {
  Calibration inside = outside;
  Vector3* const bias = f.effect == "hard_iron_change"   ? &inside.parameters.mag.front().bias
                        : f.effect == "gyro_bias_change" ? &inside.parameters.gyr_bias
                        : f.effect == "acc_bias_change"  ? &inside.parameters.acc_bias
                                                         : nullptr;
  if (bias == nullptr) return std::nullopt;
  for (int axis = 0; axis < 3; ++axis) {
    const auto p =
        std::ranges::find(f.parameters, fmt::format("s[{}]", axis), &FoundParameter::name);
    if (p == f.parameters.end()) return std::nullopt;
    (*bias)[axis] += p->value;
  }
  return inside;
}

}  // namespace

bool Against::changed() const {
  return std::any_of(groups.begin(), groups.end(), [](const Change& c) { return c.changed; });
}

Against compare_calibrations(const Calibration& stored, const Calibration& now, int blocks,
                             double false_alarm_rate, const Excess& excess) {
  Against out;
  for (const auto& [c, which] : {std::pair(&stored, "stored"), std::pair(&now, "new")}) {
    for (const std::string& u : c->undetermined) {
      out.notes.push_back(
          fmt::format("Nothing can be compared: the {} calibration leaves open {}", which, u));
    }
  }
  if (!out.notes.empty()) return out;
  out.tested = true;
  const std::vector<Difference> all = differences(stored, now);
  for (const Difference& d : all) {
    const auto it = excess.find(d.group);
    out.groups.push_back(judged(d, blocks, false_alarm_rate / double(all.size()),
                                it == excess.end() ? 1.0 : std::max(1.0, it->second)));
  }
  return out;
}

Against compare_with(const Calibration& stored, const std::string& stored_name,
                     const std::vector<const Recording*>& recordings, const AgainstOptions& given) {
  const auto has = [&](const std::string& name) {
    return std::any_of(stored.effects.begin(), stored.effects.end(),
                       [&](const ActiveEffect& e) { return e.name == name; });
  };
  CalibrationOptions options;
  options.noise = given.noise;
  options.gravity = stored.gravity;
  options.motion = stored.motion;
  options.mag_time_offset = has("mag_time_offset");
  options.gyr_matrix = has("gyro_scale_misalignment") && is_moved(stored.motion);
  const Calibration now = calibrate_whole(recordings, options);
  const int blocks = blocks_of(recordings);
  Against out = compare_calibrations(stored, now, blocks, given.false_alarm_rate);
  if (out.changed()) {
    out = compare_calibrations(stored, now, blocks, given.false_alarm_rate,
                               excess_of_halves(recordings, options));
  }
  out.calibration = stored_name;
  const auto note_trust = [&](const Calibration& c, const std::string& which) {
    if (c.trust.verdict == Verdict::kNo) {
      out.notes.push_back(fmt::format("The {} calibration is not to be trusted: {}", which,
                                      c.trust.reasons.front()));
    }
  };
  note_trust(stored, "stored");
  note_trust(now, "new");
  out.told = now.trust.verdict != Verdict::kNo;
  for (const ActiveEffect& e : stored.effects) {
    if (e.name == "mag_time_offset" || e.name == "gyro_scale_misalignment") continue;
    out.notes.push_back(fmt::format(
        "The effect \"{}\" is part of the stored calibration and was left out of the comparison.",
        effect_words(e.name)));
  }
  if (stored.fields.size() > 1 || now.fields.size() > 1) {
    out.notes.push_back("Dips are compared between single recordings only.");
  }
  return out;
}

void compare_beside_causes(const Calibration& stored,
                           const std::vector<const Recording*>& recordings, const Diagnosis& d,
                           Against& out) {
  std::vector<const Finding*> changes;
  for (const Finding& f : d.findings) {
    if (is_change(f.effect)) changes.push_back(&f);
  }
  const int blocks = blocks_of(recordings);
  if (!changes.empty() && d.after.fit.converged()) {
    Against outside = compare_calibrations(stored, d.after, blocks, d.false_alarm_rate);
    if (outside.tested) {
      out.groups = std::move(outside.groups);
      out.tested = out.told = true;
      out.notes.clear();
      for (const Finding* f : changes) {
        out.within.push_back(fmt::format("{} {}", effect_words(f->effect), when_changed(*f)));
      }
    }
  }
  if (out.within.size() == 1) {
    if (const auto inside = while_it_lasts(d.after, *changes.front())) {
      const Against then = compare_calibrations(stored, *inside, blocks, d.false_alarm_rate);
      if (then.tested && !then.changed()) out.fits_only = when_changed(*changes.front());
    }
  }
  for (const Finding& f : d.findings) {
    if (!belongs_to_recording(f.effect) || (is_change(f.effect) && !out.within.empty())) continue;
    out.notes.push_back(fmt::format(
        "The cause \"{}\" was found in these recordings; the comparison does not know of it.",
        effect_words(f.effect)));
  }
}

}  // namespace magimu

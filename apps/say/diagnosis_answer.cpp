// SPDX-License-Identifier: BSD-3-Clause
#include "apps/say/diagnosis_answer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>

#include "apps/say/numbers.h"
#include "diagnosis/compare/change_text.h"
#include "diagnosis/result/sentence_words.h"
#include "graph/sensor.h"

namespace magimu::apps {
namespace {

constexpr double kBeyondDoubt = 1e5;  // nats: a gain beyond is written without digits

std::string counted(std::size_t n) {
  constexpr const char* kWords[] = {"no", "one", "two", "three", "four", "five", "six"};
  return n < std::size(kWords) ? kWords[n] : fmt::format("{}", n);
}

std::string with_stop(const std::string& text) {
  return text.empty() || text.back() == '.' ? text : text + ".";
}

// The basic model's parameters, by the names that `order` has for them.
struct Named {
  std::string label, unit;
  double value;
};
std::map<std::string, Named> values_of(const Calibration& c) {
  std::map<std::string, Named> out;
  const auto& mags = c.parameters.mag;
  for (int i = 0; i < 3; ++i) {
    const char axis = "xyz"[i];
    out[fmt::format("accelerometer.bias[{}]", i)] = {fmt::format("accelerometer bias {}", axis),
                                                     "m/s^2", c.parameters.acc_bias[i]};
    out[fmt::format("gyroscope.bias[{}]", i)] = {fmt::format("gyroscope bias {}", axis), "rad/s",
                                                 c.parameters.gyr_bias[i]};
    for (std::size_t m = 0; m < mags.size(); ++m) {
      const std::string of = mags.size() == 1 ? "magnetometer" : c.mag_names[m];
      out[fmt::format("magnetometers[{}].bias[{}]", m, i)] = {fmt::format("{} bias {}", of, axis),
                                                              "uT", mags[m].bias[i]};
      for (int j = 0; j < 3; ++j) {
        out[fmt::format("magnetometers[{}].distortion[{}][{}]", m, i, j)] = {
            fmt::format("{} distortion D {}{}", of, axis, "xyz"[j]), "uT",
            mags[m].distortion(i, j)};
      }
    }
  }
  for (std::size_t r = 0; r < c.fields.size(); ++r) {
    const double dip = c.fields[r].dip_rad / kDegree;
    if (c.fields.size() == 1) {
      out["field.dip_deg"] = {"dip of the field", "deg", dip};
    } else {
      out[fmt::format("fields[{}].dip_deg", r)] = {"dip, " + c.fields[r].recording, "deg", dip};
    }
  }
  return out;
}

}  // namespace

std::string headline(const Diagnosis& d) {
  switch (d.answer) {
    case Answer::kExplained:
    case Answer::kPartly:
      if (d.findings.empty()) {
        return "The simulation predicts these data, but for the samples that were set aside.";
      }
      return fmt::format("The simulation gets {} thing{} wrong in these data{}.",
                         counted(d.findings.size()), d.findings.size() == 1 ? "" : "s",
                         d.answer == Answer::kPartly
                             ? ", and something is left that none of the known causes explains"
                             : "");
    case Answer::kUnexplained:
      return "The simulation does not predict these data, and none of the known causes explains "
             "why.";
    case Answer::kPredicts:
      return "The simulation predicts these data.";
    case Answer::kNone:
      break;
  }
  return "These data do not permit an answer.";
}

std::string effect_title(const std::string& effect, const std::string& channel) {
  const std::string out = effect_words(effect);
  // Effects that exist for every sensor.
  const bool needs_sensor =
      effect == "noise_scale" || effect == "correlated_noise" || effect == "outliers";
  return needs_sensor && !channel.empty() ? out + ", " + in_words(channel) : out;
}

bool is_finding_of(const ScanEntry& e, const Finding& f) {
  return f.effect == e.effect && (f.channel == e.channel || f.channel.empty() || e.channel.empty());
}

Outcome outcome_of(const ScanEntry& e, const Diagnosis& d) {
  const auto is_it = [&](const Finding& f) { return is_finding_of(e, f); };
  if (std::any_of(d.findings.begin(), d.findings.end(), is_it)) return Outcome::kFound;
  if (!e.needs.empty()) return Outcome::kUntested;
  return e.significant ? Outcome::kExplained : Outcome::kNotFound;
}

std::vector<const ScanEntry*> entries_with(Outcome outcome, const Diagnosis& d) {
  std::vector<const ScanEntry*> out;
  for (const ScanEntry& e : d.scan) {
    if (outcome_of(e, d) == outcome) out.push_back(&e);
  }
  return out;
}

std::string needs_words(const ScanEntry& e) {
  const bool column = e.needs == "temp" || e.needs == "current" || e.needs == "pos";
  return column ? "the recordings have no column " + e.needs : e.needs;
}

std::string size_words(const FoundParameter& p) {
  const bool bare = p.unit.empty() || p.unit == "-" || p.unit == "1";
  return with_sigma(p.value, p.sigma) + (bare ? "" : " " + p.unit);
}

std::vector<std::string> confusable_words(const std::vector<Confusable>& confusable) {
  struct Alike {
    std::string why, names, motions;
  };
  std::vector<Alike> alike;
  const auto add = [](std::string& to, const std::string& separator, const std::string& what) {
    if (!what.empty() && to.find(what) == std::string::npos) {
      to += (to.empty() ? "" : separator) + what;
    }
  };
  for (const Confusable& c : confusable) {
    auto same =
        std::find_if(alike.begin(), alike.end(), [&](const Alike& a) { return a.why == c.why; });
    if (same == alike.end()) same = alike.insert(alike.end(), {c.why, "", ""});
    add(same->names, ", ", effect_title(c.effect));
    add(same->motions, "; ", c.motion_that_separates);
  }
  std::vector<std::string> out;
  for (const Alike& a : alike) {
    out.push_back(with_stop(a.why.empty() ? a.names : a.names + ": " + a.why));
    if (!a.motions.empty()) out.back() += " To separate: " + with_stop(a.motions);
  }
  return out;
}

std::string detectable_words(const ScanEntry& entry) {
  return entry.detectable.empty() ? "no sign of it" : entry.detectable;
}

double heldout_gain(const Gain& gain) { return gain.heldout_nll_before - gain.heldout_nll_after; }

std::string heldout_number(const Gain& gain) {
  const double nats = heldout_gain(gain);
  if (!std::isfinite(nats)) return "-";
  if (nats >= kBeyondDoubt) return fmt::format("more than {:+.0f}", kBeyondDoubt);
  return fmt::format("{:+.1f}", nats);
}

std::string heldout_words(const Gain& gain) {
  const double nats = heldout_gain(gain);
  if (!std::isfinite(nats)) return "the gain on left-out data could not be measured";
  if (nats <= 0.0) {
    return fmt::format("left-out data are not predicted better (log-likelihood {:+.1f})", nats);
  }
  // No digits for what is certain anyway. (If the noise was assumed far too small, gains are
  // millions of nats.)
  if (nats >= kBeyondDoubt) {
    return fmt::format("left-out data are predicted far better (log-likelihood {})",
                       heldout_number(gain));
  }
  return fmt::format("left-out data are predicted better (log-likelihood {:+.{}f})", nats,
                     nats < 100.0 ? 1 : 0);
}

bool residual_of_model(const Finding& finding) {
  const bool excursions =
      !finding.parameters.empty() && finding.parameters.front().name == "excursions";
  const double before = finding.gain.residual_rms_before, after = finding.gain.residual_rms_after;
  return !excursions && std::isfinite(before) && !(after > before);
}

double Moved::sigmas() const {
  return sigma_before > 0.0 ? (after - before) / sigma_before : std::nan("");
}

std::vector<Moved> moved_parameters(const Diagnosis& d) {
  const auto before = values_of(d.before), after = values_of(d.after);
  const auto known = [](const Calibration& c, const std::string& name) {
    return std::find(c.order.begin(), c.order.end(), name) != c.order.end();
  };
  std::vector<Moved> out;
  for (const std::string& name : d.before.order) {
    if (!before.contains(name) || !after.contains(name) || !known(d.after, name)) continue;
    const Named& b = before.at(name);
    out.push_back({b.label, b.unit, b.value, d.before.sigma(name), after.at(name).value,
                   d.after.sigma(name)});
  }
  return out;
}

std::vector<std::string> unsaid_reasons(const Diagnosis& diagnosis) {
  std::vector<std::string> out;
  for (const std::string& reason : diagnosis.before.trust.reasons) {
    if (std::ranges::find(diagnosis.evidence, reason) == diagnosis.evidence.end()) {
      out.push_back(reason);
    }
  }
  return out;
}

std::vector<std::string> added_to_verdict(const Diagnosis& d) {
  std::vector<std::string> out;
  if (!d.findings.empty()) {
    out.push_back(fmt::format(
        "With what was found in its model the calibration's verdict would be `{}` (it is "
        "`calibration_after` of the file).",
        to_string(d.after.trust.verdict)));
  }
  const auto said = [&](const std::string& reason) {
    return std::ranges::find(d.evidence, reason) != d.evidence.end() ||
           std::ranges::find(d.before.trust.reasons, reason) != d.before.trust.reasons.end();
  };
  std::ranges::copy_if(d.after.trust.reasons, std::back_inserter(out), std::not_fn(said));
  return out;
}

std::string against_headline(const Against& a) {
  if (!a.tested) return fmt::format("{} cannot be compared with these recordings.", a.calibration);
  std::string changed;
  for (const Change& c : a.groups) {
    if (c.changed) changed += (changed.empty() ? "" : ", ") + change_title(c.group);
  }
  if (!a.within.empty()) {
    const std::string what = fmt::format("{}", fmt::join(a.within, ", "));
    if (changed.empty()) {
      return fmt::format(
          "{} predicts these recordings but for what changed within them: {}. Outside of that no "
          "change is seen.",
          a.calibration, what);
    }
    if (!a.fits_only.empty()) {
      return fmt::format("{} predicts these recordings {} only. Otherwise this is another: {}.",
                         a.calibration, a.fits_only, changed);
    }
    return fmt::format(
        "{} no longer predicts these recordings. What has changed: {}; and something changed "
        "within them: {}.",
        a.calibration, changed, what);
  }
  if (changed.empty() && !a.told) {
    return fmt::format(
        "Whether {} still predicts these recordings they do not tell: by themselves they permit no "
        "calibration to compare it with.",
        a.calibration);
  }
  if (changed.empty()) {
    return fmt::format(
        "{} still predicts these recordings: no change is seen. Changes larger than the limits "
        "given here would have been seen nine times out of ten; smaller ones may be there.",
        a.calibration);
  }
  return fmt::format("{} no longer predicts these recordings. What has changed: {}.", a.calibration,
                     changed);
}

}  // namespace magimu::apps

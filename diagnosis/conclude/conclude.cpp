// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conclude/conclude.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "diagnosis/conclude/departures.h"
#include "diagnosis/conclude/missing_state.h"
#include "graph/sensor.h"
#include "recording/data/set_aside.h"

namespace magimu {
namespace {

std::string sensor_of(const std::string& channel) {
  const std::string words = in_words(channel);
  return words == channel ? "magnetometer " + channel : words;
}

std::string where(const Departure& e, bool several) {
  if (!(e.end_s > e.begin_s)) return "";
  return fmt::format(", {:.0f} to {:.0f} s{}", e.begin_s, e.end_s,
                     several ? " of " + e.recording : "");
}

// What a band holds; said once.
std::string coverage_of_bands() {
  return fmt::format(
      " (the bands of all statistics together hold in {:.1f} % of recordings where nothing is "
      "wrong)",
      100.0 * (1.0 - kSimultaneous));
}

// One sentence a channel, with the strongest of its statistics.
std::vector<std::string> sentences_of(const std::vector<Departure>& departures, bool several) {
  std::vector<std::string> out;
  std::map<std::string, int> count;
  for (const Departure& e : departures) ++count[e.channel];
  for (const Departure& e : departures) {  // strongest first
    const int n = std::exchange(count[e.channel], 0);
    if (n == 0) continue;
    out.push_back(fmt::format(
        "What is left of the {} departs from what the fitted simulation predicts: its {}{} is "
        "{:.3g}, outside its band of {:.3g} to {:.3g}{} and {:.0f} standard deviations from its "
        "middle{}.",
        sensor_of(e.channel), e.statistic, where(e, several), e.observed, e.predicted_band[0],
        e.predicted_band[1], out.empty() ? coverage_of_bands() : "", std::abs(e.z),
        n == 1   ? ""
        : n == 2 ? "; one more of its statistics leaves its band"
                 : fmt::format("; {} more of its statistics leave their bands", n - 1)));
  }
  return out;
}

// Without channels in which only crumbs of what was found are left. That the hand moves the sensor
// replaces the accelerometer's part of the model: what it did not explain there it does not excuse.
std::vector<Departure> of_substance(const Diagnosis& d) {
  const bool moved = std::ranges::any_of(
      d.findings, [](const Finding& f) { return f.effect == "linear_acceleration"; });
  const bool excused = d.findings.size() > (moved ? 1 : 0);
  std::map<std::string, double> before, after;
  const auto add = [](std::map<std::string, double>& to, const std::vector<Departure>& all) {
    for (const Departure& e : all) to[e.channel] = std::max(to[e.channel], e.z * e.z);
  };
  add(before, d.departures);
  add(after, d.departures_after);
  std::vector<Departure> out;
  for (const Departure& e : d.departures_after) {
    const bool crumbs =
        excused && !(moved && e.channel == "acc") && after[e.channel] < kCrumb * before[e.channel];
    if (!crumbs) out.push_back(e);
  }
  return out;
}

const Check* halves_that_disagree(const Diagnosis& d) {
  const auto halves = std::ranges::find(d.after.checks, "halves", &Check::name);
  const bool bad = halves != d.after.checks.end() && halves->status != CheckStatus::kOk;
  return bad ? &*halves : nullptr;
}

// Samples that a fault took: rows of zeros where a slow sensor had no sample are none.
std::vector<std::string> sentences_of(const std::vector<SetAsideOf>& set_aside, bool several) {
  std::vector<std::string> out;
  for (const SetAsideOf& s : set_aside) {
    if (!(lost_share(s.what) > 0.0)) continue;
    out.push_back((several ? s.recording + ": " : "") + sentence(s.what) + ".");
  }
  return out;
}

void append(std::vector<std::string>& to, const std::vector<std::string>& more) {
  for (const std::string& sentence : more) {
    if (std::ranges::find(to, sentence) == to.end()) to.push_back(sentence);
  }
}

// Sensors in which something is left.
std::vector<std::string> channels_of(const Diagnosis& d, const std::vector<Departure>& left) {
  std::vector<std::string> out = channels_of_missing_state(d);
  append(out, d.structure.channels);
  for (const Departure& e : left) append(out, {e.channel});
  return out;
}

// Of the calibration, whose verdict is the one that counts; of the last model where only that has
// any.
const std::vector<std::string>& reasons_of_trust(const Diagnosis& d) {
  return d.before.trust.verdict >= d.after.trust.verdict ? d.before.trust.reasons
                                                         : d.after.trust.reasons;
}

}  // namespace

std::string to_string(Answer answer) {
  switch (answer) {
    case Answer::kPredicts:
      return "predicts";
    case Answer::kExplained:
      return "explained";
    case Answer::kPartly:
      return "partly";
    case Answer::kUnexplained:
      return "unexplained";
    case Answer::kNone:
      break;
  }
  return "none";
}

Conclusion conclude(const Diagnosis& d) {
  Conclusion out;
  const bool several = d.recordings.size() > 1;
  const bool named = !d.findings.empty();
  const std::vector<Departure> left = of_substance(d);
  const Check* const halves = halves_that_disagree(d);
  // Evidence to the contrary.
  const bool missing = state_is_missing(d);
  if (missing) {
    out.evidence.push_back(sentence_of_missing_state(d));
    if (std::string settle = what_would_settle_it(d); !settle.empty()) {
      out.evidence.push_back(std::move(settle));
    }
  }
  if (d.structure.detected) append(out.evidence, d.structure.evidence);
  append(out.evidence, sentences_of(left, several));
  if (halves != nullptr) out.evidence.push_back(halves->sentence);
  const bool contrary = missing || d.structure.detected || !left.empty() || halves != nullptr;
  const Unexplained unexplained = {contrary, channels_of(d, left), out.evidence};
  const std::vector<std::string> set_aside = sentences_of(d.after.set_aside, several);
  append(out.evidence, set_aside);

  if (named && !causes_take_nothing(d)) {
    out.answer = contrary ? Answer::kPartly : Answer::kExplained;
    if (contrary) out.unexplained = unexplained;
    return out;
  }
  // What a fit leaves that has not come to its end says nothing of the simulation.
  if (contrary && !d.after.fit.converged()) {
    out.evidence = d.after.trust.reasons;
    return out;
  }
  if (missing || d.structure.detected) {
    out.answer = Answer::kUnexplained;
    out.unexplained = unexplained;
    return out;
  }
  const std::size_t tested = std::size_t(
      std::ranges::count_if(d.scan, [](const ScanEntry& e) { return e.needs.empty(); }));
  if (tested == 0 || d.statistics == 0) {
    out.evidence.clear();
    if (tested == 0) out.evidence.push_back("None of the possible causes could be tested.");
    append(out.evidence, reasons_of_trust(d));
    if (tested > 0 && reasons_of_trust(d).empty()) {
      out.evidence.push_back("The fit is singular: nothing can be compared with it.");
    }
    return out;
  }
  if (contrary) {
    out.answer = Answer::kUnexplained;
    out.unexplained = unexplained;
  } else if (std::max(d.before.trust.verdict, d.after.trust.verdict) == Verdict::kNo) {
    append(out.evidence, reasons_of_trust(d));
  } else if (!set_aside.empty()) {
    out.answer = Answer::kExplained;
  } else {
    out.answer = Answer::kPredicts;
    out.evidence.push_back(fmt::format(
        "{} possible cause{} tested; none is there as far as these data can show. All {} "
        "statistics of what is left lie where simulations have them.",
        tested, tested == 1 ? " was" : "s were", d.statistics));
  }
  return out;
}

bool may_predict(const Diagnosis& d) { return conclude(d).answer == Answer::kPredicts; }

}  // namespace magimu

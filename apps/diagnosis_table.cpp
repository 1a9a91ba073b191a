// SPDX-License-Identifier: BSD-3-Clause
#include "apps/diagnosis_table.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "apps/diagnosis_answer.h"
#include "apps/numbers.h"

namespace magimu::apps {
namespace {

constexpr std::size_t kWidth = 98, kNameWidth = 34;

// Words in lines of at most kWidth; the first one begins with `first`, the others with as many
// spaces as it is wide.
std::string wrapped(const std::string& text, const std::string& first) {
  std::string out, line = first;
  bool empty = true;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find_first_of(" \n", at), text.size());
    const std::string word = text.substr(at, end - at);
    at = end + 1;
    if (word.empty()) continue;
    if (!empty && line.size() + 1 + word.size() > kWidth) {
      out += line + "\n";
      line.assign(first.size(), ' ');
      empty = true;
    }
    line += (empty ? "" : " ") + word;
    empty = false;
  }
  return out + line + "\n";
}

std::string finding_text(const Finding& f, std::size_t number) {
  std::string out = wrapped(f.sentence, fmt::format("{}. ", number));
  const std::string indent = "   ";
  out += wrapped(fmt::format("Probability {}; {}; residual of the {} {} -> {} (1: noise alone).",
                             percent(f.probability), heldout_words(f.gain), sensor_name(f.channel),
                             plain(f.gain.residual_rms_before), plain(f.gain.residual_rms_after)),
                 indent);
  std::string values;
  for (const FoundParameter& p : f.parameters) {
    values += fmt::format("{}{} = {} {}", values.empty() ? "" : ", ", p.name,
                          with_sigma(p.value, p.sigma), p.unit);
  }
  if (!values.empty()) out += wrapped(f.effect + ": " + values, indent);
  for (const Confusable& c : f.confusable_with) {
    std::string text = "Can be confused with " + effect_title(c.effect) + ": " + c.why;
    if (!c.motion_that_separates.empty()) text += ". To separate: " + c.motion_that_separates;
    out += wrapped(text, indent);
  }
  return out + "\n";
}

std::string list(const std::string& heading, const std::vector<const ScanEntry*>& entries,
                 const std::function<std::string(const ScanEntry&)>& words) {
  if (entries.empty()) return "";
  std::string out = heading + "\n";
  for (const ScanEntry* e : entries) {
    const std::string name = effect_title(e->effect, e->channel);
    out += wrapped(words(*e), fmt::format("  {:<{}} ", name, kNameWidth));
  }
  return out + "\n";
}

std::string calibration_text(const Diagnosis& d) {
  std::string out = fmt::format("Trust in the calibration: {}", to_string(d.before.trust.verdict));
  if (d.findings.empty()) return out + "\n";
  out += fmt::format(" before, {} with what was found.", to_string(d.after.trust.verdict));
  const Moved* most = nullptr;
  const std::vector<Moved> all = moved_parameters(d);
  for (const Moved& m : all) {
    if (!std::isfinite(m.sigmas())) continue;
    if (most == nullptr || std::abs(m.sigmas()) > std::abs(most->sigmas())) most = &m;
  }
  if (most != nullptr) {
    out += fmt::format(" Moved most: {}, from {} to {} {} ({:.1f} sigma).", most->name,
                       with_sigma(most->before, most->sigma_before),
                       with_sigma(most->after, most->sigma_after), most->unit,
                       std::abs(most->sigmas()));
  }
  return wrapped(out, "");
}

}  // namespace

std::string diagnosis_table(const Diagnosis& d) {
  std::string out = wrapped(headline(d), "") + "\n";
  for (std::size_t i = 0; i < d.findings.size(); ++i) out += finding_text(d.findings[i], i + 1);
  const std::vector<std::string> reasons = explanation(d);
  if (!reasons.empty()) {
    if (!d.findings.empty()) out += "Not explained:\n";
    for (const std::string& reason : reasons) out += wrapped(reason, "  - ");
    out += "\n";
  }
  out += list("Not tested, because:", entries_with(Outcome::kUntested, d),
              [](const ScanEntry& e) { return e.needs; });
  out += list(d.findings.empty() ? "Seems to be there, but does not help to predict left-out data:"
                                 : "Seems to be there, too, but is explained by the above:",
              entries_with(Outcome::kExplained, d), [](const ScanEntry&) { return ""; });
  out += list("Not found; it would have been, nine times out of ten, from this size on:",
              entries_with(Outcome::kNotFound, d), detectable_words);
  out += calibration_text(d);
  for (const std::string& note : d.notes) out += wrapped(note, "Note: ");
  out += wrapped(fmt::format("Anything at all is named in {} of recordings in which there is "
                             "nothing. {:.1f} s.",
                             percent(d.false_alarm_rate), d.seconds),
                 "");
  return out;
}

}  // namespace magimu::apps

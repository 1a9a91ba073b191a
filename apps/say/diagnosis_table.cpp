// SPDX-License-Identifier: BSD-3-Clause
#include "apps/say/diagnosis_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string_view>

#include "apps/say/diagnosis_answer.h"
#include "apps/say/numbers.h"
#include "apps/say/parameter_words.h"

namespace magimu::apps {
namespace {

constexpr std::size_t kWidth = 98, kNameWidth = 34;
constexpr std::size_t kShown = 12;  // parameters of a finding
constexpr std::size_t kRivals = 4;  // causes that a finding can be confused with

constexpr char kUnbroken = '\x1f';  // a blank at which no line ends

std::string unbroken(std::string text) {
  std::replace(text.begin(), text.end(), ' ', kUnbroken);
  return text;
}

// Text for people: a value and its uncertainty stay on one line.
std::string readable(const std::string& text) {
  constexpr std::string_view kSign = " ± ";
  std::string out = plus_minus(text);
  for (auto at = out.find(kSign); at != std::string::npos; at = out.find(kSign, at)) {
    out[at] = out[at + kSign.size() - 1] = kUnbroken;
  }
  return out;
}

// Words in lines of at most kWidth; the first one begins with `first`, the others with as many
// spaces as it is wide.
std::string wrapped(const std::string& text, const std::string& first) {
  const std::string shown = readable(text);
  std::string out, line = first;
  bool empty = true;
  for (std::size_t at = 0; at < shown.size();) {
    const std::size_t end = std::min(shown.find_first_of(" \n", at), shown.size());
    const std::string word = shown.substr(at, end - at);
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
  out += line + "\n";
  std::replace(out.begin(), out.end(), kUnbroken, ' ');
  return out;
}

// At most kShown parameters, in their order; of more than these, the clearest.
std::vector<FoundParameter> clearest_of(const std::vector<FoundParameter>& all) {
  if (all.size() <= kShown) return all;
  const auto clear = [](const FoundParameter& p) { return std::abs(p.value) / p.sigma; };
  std::vector<double> order;
  for (const FoundParameter& p : all) order.push_back(clear(p));
  std::ranges::nth_element(order, order.begin() + kShown - 1, std::greater<>());
  std::vector<FoundParameter> out;
  for (const FoundParameter& p : all) {
    if (clear(p) >= order[kShown - 1] && out.size() < kShown) out.push_back(p);
  }
  return out;
}

std::string finding_text(const Finding& f, std::size_t number) {
  std::string out = wrapped(f.sentence, fmt::format("{}. ", number));
  const std::string indent = "   ";
  std::string gain =
      fmt::format("Probability {}; {}", percent(f.probability), heldout_words(f.gain));
  const std::string before = plain(f.gain.residual_rms_before),
                    after = plain(f.gain.residual_rms_after);
  if (residual_of_model(f) && before != after) {
    gain += fmt::format("; residual of the {} {} (1: noise alone)", in_words(f.channel),
                        unbroken(before + " -> " + after));
  }
  out += wrapped(gain + ".", indent);
  std::string values;
  // What lasts has no end.
  std::vector<FoundParameter> finite = f.parameters;
  std::erase_if(finite, [](const FoundParameter& p) { return !std::isfinite(p.value); });
  const std::vector<FoundParameter> clearest = clearest_of(finite);
  for (const FoundParameter& p : clearest) {
    values += (values.empty() ? "" : "; ") + parameter_words(f.effect, p.name) + " = " +
              unbroken(size_words(p));
  }
  if (clearest.size() < finite.size()) {
    values += fmt::format("; and {} more (-o writes all)", finite.size() - clearest.size());
  }
  if (!values.empty()) out += wrapped(effect_title(f.effect) + ": " + values, indent);
  // Best first.
  std::vector<Confusable> rivals = f.confusable_with;
  const std::size_t more = rivals.size() > kRivals + 1 ? rivals.size() - kRivals : 0;
  rivals.resize(rivals.size() - more);
  for (const std::string& words : confusable_words(rivals)) {
    out += wrapped("Can be confused with " + words, indent);
  }
  if (more > 0) {
    out += wrapped(fmt::format("Can be confused with {} more, less likely (-o writes all).", more),
                   indent);
  }
  return out + "\n";
}

std::string list(const std::string& heading, const std::vector<const ScanEntry*>& entries,
                 std::string (*words)(const ScanEntry&)) {
  if (entries.empty()) return "";
  std::string out = heading + "\n";
  for (const ScanEntry* e : entries) {
    const std::string name = effect_title(e->effect, e->channel);
    out += wrapped(words(*e), fmt::format("  {:<{}} ", name, kNameWidth));
  }
  return out + "\n";
}

std::string reasons_text(const Diagnosis& d) {
  std::string out;
  for (const std::string& reason : unsaid_reasons(d)) out += wrapped(reason, "  - ");
  return out;
}

std::string moved_most(const Diagnosis& d) {
  const Moved* most = nullptr;
  const std::vector<Moved> all = moved_parameters(d);
  for (const Moved& m : all) {
    if (!std::isfinite(m.sigmas())) continue;
    if (most == nullptr || std::abs(m.sigmas()) > std::abs(most->sigmas())) most = &m;
  }
  if (d.findings.empty() || most == nullptr) return "";
  return fmt::format("Moved most by that: {}, from {} to {} {} ({:.1f} sigma).",
                     unbroken(most->name), with_sigma(most->before, most->sigma_before),
                     with_sigma(most->after, most->sigma_after), most->unit,
                     std::abs(most->sigmas()));
}

std::string calibration_text(const Diagnosis& d) {
  std::string out = fmt::format("Trust in the calibration, as `magimu calibrate` judges it: {}.\n",
                                to_string(d.before.trust.verdict)) +
                    reasons_text(d);
  std::vector<std::string> added = added_to_verdict(d);
  if (const std::string moved = moved_most(d); !moved.empty()) added.push_back(moved);
  if (!added.empty()) out += "What this diagnosis adds:\n";
  for (const std::string& sentence : added) out += wrapped(sentence, "  - ");
  return out;
}

std::string against_text(const Against& a) {
  std::string out = wrapped(against_headline(a), "");
  for (const bool changed : {true, false}) {
    for (const Change& c : a.groups) {
      if (c.changed == changed) out += wrapped(c.sentence, "  - ");
    }
  }
  for (const std::string& note : a.notes) out += wrapped(note, "  Note: ");
  return out + "\n";
}

}  // namespace

std::string diagnosis_table(const Diagnosis& d) {
  std::string out;
  if (d.against) out += against_text(*d.against);
  out += wrapped(headline(d), "") + "\n";
  for (std::size_t i = 0; i < d.findings.size(); ++i) out += finding_text(d.findings[i], i + 1);
  const std::vector<std::string>& reasons = d.evidence;
  if (!reasons.empty()) {
    if (d.answer == Answer::kPartly) out += "Not explained:\n";
    const char* bullet = reasons.size() > 1 || !d.findings.empty() ? "  - " : "";
    for (const std::string& reason : reasons) out += wrapped(reason, bullet);
    out += "\n";
  }
  out += list("Not tested, because:", entries_with(Outcome::kUntested, d), needs_words);
  std::string explained;
  for (const ScanEntry* e : entries_with(Outcome::kExplained, d)) {
    explained += (explained.empty() ? "" : ", ") + effect_title(e->effect, e->channel);
  }
  if (!explained.empty()) {
    out += d.findings.empty() ? "Seen, but left-out data are not predicted better with it:\n"
                              : "Seen, too, as long as the above is not part of the model:\n";
    out += wrapped(explained, "  ") + "\n";
  }
  out += list("Not found; it would have been, nine times out of ten, from this size on:",
              entries_with(Outcome::kNotFound, d), detectable_words);
  out += calibration_text(d);
  for (const std::string& note : d.notes) out += wrapped(note, "Note: ");
  if (!d.next_step.empty()) out += wrapped(d.next_step, "");
  out += wrapped(fmt::format("False alarms: where nothing is wrong, something is named in {} of "
                             "recordings. Computed in {:.1f} s.",
                             percent(d.false_alarm_rate), d.seconds),
                 "");
  return out;
}

}  // namespace magimu::apps

// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/diagnosis_scan_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "apps/plot/plot.h"
#include "apps/say/diagnosis_answer.h"
#include "apps/say/numbers.h"

namespace magimu::apps {
namespace {

constexpr double kLow = 0.1;  // where bars begin

// -log10(p), at most 300.
double zeros_of(double p_value) { return std::max(0.0, -std::log10(std::max(p_value, 1e-300))); }

// The larger of its evidence in the scan (as the only cause) and when it entered the model.
double evidence_of_found(const ScanEntry& e, const Diagnosis& d) {
  double most = evidence(e);
  for (const Finding& f : d.findings) {
    if (is_finding_of(e, f)) most = std::fmax(most, zeros_of(f.p_value));
  }
  return most;
}

plot::RowChart::Row row_of(const ScanEntry& e, const Diagnosis& d) {
  using plot::Colour;
  plot::RowChart::Row row{effect_title(e.effect, e.channel), evidence(e), Colour::kGrey, ""};
  switch (outcome_of(e, d)) {
    case Outcome::kFound:
      row.colour = Colour::kVermilion;
      row.value = evidence_of_found(e, d);
      row.note = "found";
      break;
    case Outcome::kExplained:
      row.colour = Colour::kOrange;
      break;
    case Outcome::kNotFound:
      row.colour = Colour::kSky;
      break;
    case Outcome::kUntested:
      row.value = std::numeric_limits<double>::quiet_NaN();
      row.note = "not tested: " + needs_words(e);
      break;
  }
  if (std::isfinite(row.value)) {
    row.note += fmt::format("{}{:.3g}", row.note.empty() ? "" : ", ", row.value);
  }
  return row;
}

}  // namespace

double evidence(const ScanEntry& e) {
  if (std::isnan(e.p_value)) return e.p_value;
  if (e.p_value > 1e-290) return std::max(0.0, -std::log10(e.p_value));
  // The upper tail of chi-square far out: (x/2)^(k/2 - 1) exp(-x/2) / Gamma(k/2).
  const double half = 0.5 * e.dof, x = 0.5 * e.statistic;
  const double log_p = (half - 1.0) * std::log(x) - x - std::lgamma(half);
  return std::isfinite(log_p) ? std::max(290.0, -log_p / std::numbers::ln10) : 290.0;
}

double evidence_needed(const Diagnosis& d) {
  const auto tested = std::count_if(d.scan.begin(), d.scan.end(),
                                    [](const ScanEntry& e) { return e.needs.empty(); });
  return -std::log10(d.false_alarm_rate / double(std::max<std::ptrdiff_t>(1, tested)));
}

std::string scan_chart(const Diagnosis& d) {
  using plot::Colour;
  plot::RowChart chart;
  chart.title = "Evidence for each cause, taken alone";
  chart.x_label = "zeros in the odds against mere chance (3: one in 1000)";
  chart.log = true;
  chart.low = kLow;
  chart.threshold = evidence_needed(d);
  chart.threshold_name = "needed";
  const auto explain = [&](Outcome outcome, const char* words, Colour colour) {
    if (!entries_with(outcome, d).empty()) chart.legend.push_back({words, colour});
  };
  explain(Outcome::kFound, "found", Colour::kVermilion);
  explain(Outcome::kExplained,
          d.findings.empty() ? "no gain on left-out data" : "explained by what was found",
          Colour::kOrange);
  explain(Outcome::kNotFound, "not found", Colour::kSky);
  const auto tested = [&](const ScanEntry& e) { return outcome_of(e, d) != Outcome::kUntested; };
  for (const ScanEntry& e : d.scan) {
    if (tested(e)) chart.rows.push_back(row_of(e, d));
  }
  std::stable_sort(chart.rows.begin(), chart.rows.end(),
                   [](const auto& a, const auto& b) { return a.value > b.value; });
  for (const ScanEntry& e : d.scan) {
    if (!tested(e)) chart.rows.push_back(row_of(e, d));
  }
  return plot::svg(chart);
}

}  // namespace magimu::apps

// SPDX-License-Identifier: BSD-3-Clause
#include "apps/page/diagnosis_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "apps/page/diagnosis_disturbance.h"
#include "apps/page/diagnosis_scan_chart.h"
#include "apps/page/report.h"
#include "apps/page/residual_pictures.h"
#include "apps/plot/plot.h"
#include "apps/say/diagnosis_answer.h"
#include "apps/say/numbers.h"
#include "apps/say/parameter_words.h"

namespace magimu::apps {
namespace {

std::string joined(const std::vector<std::string>& parts, const char* separator) {
  std::string out;
  for (const std::string& part : parts) out += (out.empty() ? "" : separator) + part;
  return out;
}

void answer(Page& page, const Diagnosis& d) {
  constexpr const char* kClass[] = {"answer predicts", "answer findings", "answer findings",
                                    "answer unexplained", "answer"};
  std::string html = element("p", "magimu diagnose: " + joined(d.recordings, ", "), "kicker");
  if (d.against) html += element("h1", against_headline(*d.against));
  html += element(d.against ? "p" : "h1", headline(d));
  std::string sentences;
  for (const Finding& f : d.findings) sentences += element("li", plus_minus(f.sentence));
  if (!sentences.empty()) html += wrap("ol", sentences);
  for (const std::string& sentence : d.evidence) {
    html +=
        element("p", (d.answer == Answer::kPartly ? "Not explained: " : "") + plus_minus(sentence));
  }
  for (const std::string& reason : unsaid_reasons(d)) html += element("p", "Trust: " + reason);
  for (const std::string& added : added_to_verdict(d)) html += element("p", added);
  if (!d.next_step.empty()) html += element("p", d.next_step);
  page.html(wrap("div", html, kClass[int(d.answer)]));
  page.html(wrap("ul",
                 fact(fmt::format("{}", d.before.samples), "IMU samples used") +
                     fact(moved_how(d.after.motion), "motion, as modelled") +
                     fact(to_string(d.before.trust.verdict), "trust in the calibration") +
                     (d.findings.empty() ? std::string()
                                         : fact(to_string(d.after.trust.verdict),
                                                "trust, with what was found in the model")) +
                     fact(percent(d.false_alarm_rate), "false alarms where nothing is wrong"),
                 "facts"));
}

// How wrong, where, when.
void missing(Page& page, const Diagnosis& d) {
  if (d.missing.empty()) return;
  page.section(d.missing_series.empty() ? "Is anything missing?" : "What is missing");
  for (const MissingSeries& s : d.missing_series) {
    if (!s.t.empty()) page.figure(disturbance_picture(s), disturbance_caption(s));
  }
  std::vector<std::vector<std::string>> rows;
  for (const MissingState& m : d.missing) {
    const bool there = m.size > 0.0;
    rows.push_back({m.frame == "navigation" ? "field (fixed axes)" : in_words(m.channel),
                    plain(m.gain_nats), plain(m.taken_by_findings()), plain(m.taken_by_place),
                    plain(m.left_nats), there ? plain(m.size) + " " + m.unit : "-",
                    there ? plain(m.memory_s) + " s" : "-", m.noise});
  }
  page.paragraph(
      "A disturbance that may go where it likes was added to one sensor after the other. How much "
      "more probable the readings are with it says how wrong the simulation is there, whatever the "
      "cause. Where nothing is wrong it hardly ever gains 6 nats.");
  page.table({"disturbed", "gains, nats", "taken by causes", "by the field of the place", "left",
              "size", "memory", "the noise named above"},
             rows, 1);
}

// Does the field differ from place to place?
void place(Page& page, const Diagnosis& d) {
  if (!d.place || d.place->points.empty()) return;
  page.section("Does the field differ from place to place?");
  page.figure(place_picture(*d.place), place_caption(*d.place));
  page.html(wrap("ul", items(place_words(d))));
}

std::string finding_card(const Finding& f, std::size_t number) {
  std::string html =
      element("p", fmt::format("{}. {}", number, effect_title(f.effect, f.channel)), "kicker");
  html += element("h3", plus_minus(f.sentence));
  const Gain& g = f.gain;
  html += wrap("ul",
               fact(percent(f.probability), "probability of this cause") +
                   fact(heldout_number(g), "log-likelihood of data the fit had not seen") +
                   (residual_of_model(f)
                        ? fact(fmt::format("{} → {}", plain(g.residual_rms_before),
                                           plain(g.residual_rms_after)),
                               "residual of the " + in_words(f.channel) + "; noise alone: 1")
                        : std::string()),
               "facts");
  std::vector<std::vector<std::string>> rows;
  for (const FoundParameter& p : f.parameters) {
    if (!std::isfinite(p.value)) continue;  // what lasts has no end
    rows.push_back({parameter_words(f.effect, p.name), size_words(p),
                    p.sigma > 0.0 ? fmt::format("{:.1f}", std::abs(p.value) / p.sigma) : "-"});
  }
  if (!rows.empty()) html += table_html({"parameter", "size ± sigma", "size / sigma"}, rows);
  const std::vector<std::string> confusable = confusable_words(f.confusable_with);
  if (!confusable.empty()) {
    html += element("p", "It can be confused with", "soft") + wrap("ul", items(confusable));
  }
  return wrap("div", html, "card");
}

void found(Page& page, const Diagnosis& d) {
  if (!d.findings.empty()) page.section("What was found");
  for (std::size_t i = 0; i < d.findings.size(); ++i) {
    page.html(finding_card(d.findings[i], i + 1));
  }
  if (!d.unexplained.detected) return;
  if (d.findings.empty()) page.section("What is there, and has no name");
  std::vector<std::string> sensors;
  for (const std::string& channel : d.unexplained.channels) {
    sensors.push_back(in_words(channel));
  }
  page.html(
      wrap("div",
           element("p", "not explained: " + joined(sensors, ", "), "kicker") +
               element("h3", "What none of the known causes explains") +
               wrap("ul", items(d.unexplained.evidence)) +
               element("p", "No name is given: a wrong one would be worse than none.", "soft"),
           "card unexplained"));
}

void departure_table(Page& page, const std::vector<Departure>& departures) {
  constexpr std::size_t kShown = 30;
  std::vector<std::vector<std::string>> rows;
  for (const Departure& e : departures) {
    if (rows.size() == kShown) break;
    rows.push_back(
        {in_words(e.channel), e.statistic,
         e.end_s > e.begin_s ? fmt::format("{:.0f} to {:.0f} s", e.begin_s, e.end_s) : "throughout",
         plain(e.observed), plain(e.predicted),
         plain(e.predicted_band[0]) + " to " + plain(e.predicted_band[1]),
         std::isfinite(e.z) ? fmt::format("{:.1f}", e.z) : "-"});
  }
  page.table({"sensor", "statistic", "when", "observed", "predicted", "band", "sigmas away"}, rows,
             3);
  if (departures.size() > kShown) {
    page.paragraph(fmt::format("And {} more.", departures.size() - kShown));
  }
}

void departures(Page& page, const Diagnosis& d) {
  page.section("Where measurement and simulation part");
  if (d.departures.empty() && d.departures_after.empty()) {
    page.paragraph("Nowhere: every statistic of the residuals lies where simulations have it.");
    return;
  }
  page.paragraph(
      "Statistics of the residuals that leave the band of simulations of the fitted model. All of "
      "them together leave their bands in 0.3 % of recordings where nothing is wrong.");
  if (d.departures.empty()) {
    page.paragraph("Of the basic model: none.");
  } else {
    departure_table(page, d.departures);
  }
  if (d.findings.empty()) return;
  if (d.departures_after.empty()) {
    page.paragraph("With what was found in the model: none.");
    return;
  }
  page.paragraph("With what was found in the model:");
  departure_table(page, d.departures_after);
}

void scan(Page& page, const Diagnosis& d) {
  if (d.scan.empty()) return;
  page.section("Every cause that was looked for");
  page.figure(scan_chart(d),
              "Each cause is tested as if it were the only one, so that a strong one also raises "
              "those that look like it; one that was found counts as when it entered the model, "
              "where that is more. Bars, and the numbers beside them: zeros in the odds against "
              "mere chance. Right of the dashed line: more than chance explains, among so many "
              "tests.");
}

void residuals(Page& page, const Diagnosis& d) {
  const auto departed = [&](const ResidualTrace& trace) {
    const auto is_it = [&](const auto& x) { return x.channel == to_string(trace.channel); };
    return std::any_of(d.departures.begin(), d.departures.end(), is_it) ||
           std::any_of(d.findings.begin(), d.findings.end(), is_it);
  };
  const bool all = std::none_of(d.traces.begin(), d.traces.end(), departed);
  for (const ResidualTrace& trace : d.traces) {
    if (trace.t.empty() || !(all || departed(trace))) continue;
    page.section(std::string("What the simulation leaves of the ") + in_words(trace.channel));
    const ResidualPictures pictures = residual_pictures(trace, !d.findings.empty());
    page.figure(pictures.traces,
                "Measured less simulated, in standard deviations of the noise. With the right "
                "simulation it is noise, and stays within the grey band for 99 % of the time.");
    page.html("<div class=\"pair\">\n");
    page.figure(pictures.correlation, "Noise forgets at once: all of it in the grey band.");
    page.figure(pictures.spectrum, "Noise is flat. Low frequencies: drifts; peaks: vibration.");
    page.html("</div>\n");
  }
}

void not_seen(Page& page, const Diagnosis& d) {
  std::vector<std::vector<std::string>> absent, untested;
  for (const ScanEntry* e : entries_with(Outcome::kNotFound, d)) {
    absent.push_back(
        {effect_title(e->effect, e->channel), detectable_words(*e), plain(e->p_value)});
  }
  for (const ScanEntry* e : entries_with(Outcome::kUntested, d)) {
    untested.push_back({effect_title(e->effect, e->channel), needs_words(*e)});
  }
  if (absent.empty() && untested.empty()) return;
  page.section("What could not have been seen");
  if (!absent.empty()) {
    page.paragraph(
        "These causes were not found. Each may still be there below the size given, from which on "
        "it would have been found nine times out of ten in these data.");
    page.table({"cause", "found from this size on", "p-value"}, absent, 2);
  }
  if (!untested.empty()) {
    page.paragraph("These could not be tested.");
    page.table({"cause", "what is missing"}, untested, 2);
  }
}

void against(Page& page, const Diagnosis& d) {
  if (!d.against) return;
  page.section("Against the stored calibration");
  std::vector<std::string> changed, same;
  for (const Change& c : d.against->groups) (c.changed ? changed : same).push_back(c.sentence);
  changed.insert(changed.end(), same.begin(), same.end());
  changed.insert(changed.end(), d.against->notes.begin(), d.against->notes.end());
  for (std::string& sentence : changed) sentence = plus_minus(std::move(sentence));
  page.html(wrap("ul", items(changed)));
}

void calibration(Page& page, const Diagnosis& d) {
  std::vector<std::vector<std::string>> rows;
  for (const Moved& m : moved_parameters(d)) {
    rows.push_back({m.name, with_sigma(m.before, m.sigma_before),
                    with_sigma(m.after, m.sigma_after), m.unit,
                    std::isfinite(m.sigmas()) ? fmt::format("{:+.1f}", m.sigmas()) : "-"});
  }
  if (rows.empty() || d.findings.empty()) return;
  page.section("The calibration before and after");
  page.paragraph("Last column: how far the value moved, in standard deviations as stated before.");
  page.table({"parameter", "before", "after", "unit", "moved, sigmas"}, rows);
}

void method(Page& page, const Diagnosis& d) {
  page.section("How this was tested");
  page.paragraph(fmt::format(
      "The sensor's simulation was fitted to the data. Every known cause of a difference was then "
      "tested by a score test: how well the residuals point in the direction in which this cause "
      "would move them, the trajectory and the calibration being free to absorb what they can. "
      "The strongest cause entered the model if data left out of the fit, in blocks, were "
      "predicted better with it, and the search began again. All tests together name something, "
      "where there is nothing, in {} of recordings.",
      percent(d.false_alarm_rate)));
  if (!d.notes.empty()) page.html(wrap("ul", items(d.notes), "soft"));
  page.paragraph(fmt::format("Computed by magimu in {:.1f} s.", d.seconds), "soft");
}

}  // namespace

std::string diagnosis_report(const Diagnosis& d) {
  Page page("Diagnosis of " + joined(d.recordings, ", "));
  answer(page, d);
  against(page, d);
  missing(page, d);
  place(page, d);
  found(page, d);
  scan(page, d);
  residuals(page, d);
  departures(page, d);
  not_seen(page, d);
  calibration(page, d);
  method(page, d);
  return page.finish();
}

}  // namespace magimu::apps

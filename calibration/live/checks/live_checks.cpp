// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/checks/live_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "calibration/live/checks/certain_issues.h"
#include "calibration/live/checks/live_mounting.h"
#include "calibration/trust/check_axes.h"
#include "calibration/trust/field_check.h"
#include "recording/checks/dead_magnetometers.h"
#include "recording/checks/gate.h"
#include "recording/data/axes.h"
#include "recording/data/times/arrival_stamps.h"
#include "recording/data/times/row_times.h"

namespace magimu {
namespace {

// s of data after which the samples are looked at; then every kEvery.
constexpr double kLooks[] = {2.0, 3.0, 4.0, 4.8, 6.5, 8.0, 10.0, 12.0, 15.0, 20.0, 30.0};
constexpr double kEvery = 30.0;  // s
// Samples that are kept: those of the last minute, but at least so many (if times are in a wrong
// unit) and at most so many (memory).
constexpr double kKept = 60.0;  // s
constexpr std::size_t kKeptAtLeast = 400, kKeptAtMost = 60000;
// New samples before the next look: an eighth of all so far, within these bounds, so that a wrong
// clock costs no more time than a right one.
constexpr long kNewAtLeast = 20, kNewAtMost = 500;
// s of data before a sensor without samples is reported.
constexpr double kForAbsence = 4.0;
// Rows of slower sensors are late by less than kLate. After a gap of kOtherPart, or a reset, a new
// part begins.
constexpr double kLate = 1.0, kOtherPart = kPartGap - 1.0;  // s
// s without a sample, or turning with none that is new, and times the longest such time before.
constexpr double kSilent = 2.0, kSilentBefore = 3.0;
constexpr double kTurnsFast = 0.2;  // rad/s
constexpr long kHasMeasured = 20;  // changes of a reading, after which its sensor hangs, if it does
constexpr double kDipKnown = 5.0;  // standard deviations from 0 of a dip whose sign is known
constexpr double kNearby = 1.0;    // s: a fault so near to a window may explain it

bool has_place(const Issue& issue) { return issue.begin_s != 0.0 || issue.end_s != 0.0; }

bool any_fatal(const std::vector<Issue>& issues) {
  return std::ranges::any_of(issues,
                             [](const Issue& issue) { return issue.severity == Severity::kFatal; });
}

bool same(const Issue& a, const Issue& b) {
  // Samples set aside for different reasons are different issues, and have different remedies.
  return a.kind == b.kind && a.sensor == b.sensor && a.axis == b.axis &&
         (a.kind != "set_aside" || a.remedy == b.remedy);
}

// Of issues that are the same, only the gravest.
std::vector<Issue> without_doubles(std::vector<Issue> issues) {
  std::ranges::stable_sort(issues,
                           [](const Issue& a, const Issue& b) { return a.severity > b.severity; });
  std::vector<Issue> out;
  for (Issue& issue : issues) {
    const bool there = std::ranges::any_of(out, [&](const Issue& o) { return same(o, issue); });
    if (!there) out.push_back(std::move(issue));
  }
  return out;
}

// Gives samples that were stamped on arrival even times, as for a file (row_times.h), and returns
// one issue for all of them.
std::vector<Issue> with_even_times(Recording& r) {
  std::vector<Issue> out;
  const auto mend = [&](VectorSeries& series, const std::string& name) {
    std::optional<EvenTimes> even = even_times(series.t);
    if (!even) return;
    series.t = std::move(even->t);
    if (!out.empty()) return;
    out.push_back(
        {"arrival", name, -1, Severity::kCaution, 0.0, 0.0,
         fmt::format("samples are stamped on arrival, about {:.3g} at a time every {:.3g} "
                     "ms, not when they were measured",
                     even->in_a_burst, 1e3 * even->burst_s),
         fmt::format("give their rate, --rate {}, or send the time of each sample",
                     rate_text(even->rate_hz))});
  };
  mend(r.gyr, "gyr");
  mend(r.acc, "acc");
  for (std::size_t m = 0; m < r.mag.size(); ++m) mend(r.mag[m], r.mag_names[m]);
  return out;
}

std::vector<Issue> absent_sensors(const Recording& r) {
  std::vector<Issue> out;
  const auto look_for = [&](const VectorSeries& series, const std::string& name, bool needed) {
    if (!series.empty()) return;
    out.push_back({"absent", name, -1, needed ? Severity::kFatal : Severity::kCaution, 0.0, 0.0,
                   fmt::format("there are no samples of {}: its columns are empty", name),
                   "look at the board and its wires"});
  };
  look_for(r.acc, "acc", true);
  look_for(r.gyr, "gyr", true);
  for (std::size_t m = 0; m < r.mag.size(); ++m) look_for(r.mag[m], r.mag_names[m], m == 0);
  return out;
}

std::string capitalised(std::string text) {
  for (const char* word : {"the ", "every ", "samples ", "there "}) {
    if (!text.starts_with(word)) continue;
    text.front() = char(std::toupper(static_cast<unsigned char>(text.front())));
  }
  return text;
}

}  // namespace

LiveChecks::LiveChecks(LiveChecksOptions options) : options_(std::move(options)) {}

void LiveChecks::add(const StreamSample& sample) {
  if (!std::isfinite(sample.t)) return;
  // (With times in a wrong unit all samples are so far apart, and must be looked at: hence
  // kNewAtLeast.)
  const bool gap = sample.t > latest_s_ + kOtherPart && in_part_ >= kNewAtLeast;
  if (samples_.empty() || sample.t < latest_s_ - kLate || gap) {
    samples_.clear();
    begin_s_ = latest_s_ = sample.t;
    in_part_ = since_look_ = 0;
    next_look_ = 0;
    heard_.clear();
  }
  count_readings(sample);
  listen(sample);
  samples_.push_back(sample);
  latest_s_ = std::max(latest_s_, sample.t);
  ++in_part_;
  ++since_look_;
  while (samples_.size() > kKeptAtMost ||
         (samples_.size() > kKeptAtLeast && samples_.front().t < sample.t - kKept)) {
    samples_.pop_front();
  }
  if (due()) look();
}

void LiveChecks::count_readings(const StreamSample& sample) {
  readings_.resize(2 + options_.mag_names.size());
  const auto count = [](const std::optional<Vector3>& v, Reading& of) {
    if (!v || !v->allFinite()) return;
    for (int axis = 0; axis < 3; ++axis) {
      of.changes[std::size_t(axis)] += of.last && (*of.last)[axis] != (*v)[axis] ? 1 : 0;
    }
    of.last = v;
  };
  count(sample.acc, readings_[0]);
  count(sample.gyr, readings_[1]);
  for (std::size_t m = 0; m < std::min(sample.mag.size(), options_.mag_names.size()); ++m) {
    count(sample.mag[m], readings_[2 + m]);
  }
}

void LiveChecks::listen(const StreamSample& sample) {
  if (heard_.empty()) heard_.resize(2 + options_.mag_names.size());
  const double elapsed_s = std::clamp(sample.t - latest_s_, 0.0, kLate);
  const bool turns = sample.gyr && sample.gyr->norm() > kTurnsFast;
  const double turned_s = turns ? elapsed_s : 0.0;
  listen_to("acc", sample.acc, sample.t, elapsed_s, turned_s, heard_[0]);
  listen_to("gyr", sample.gyr, sample.t, elapsed_s, turned_s, heard_[1]);
  for (std::size_t m = 0; m < std::min(sample.mag.size(), options_.mag_names.size()); ++m) {
    if (is_left_out(m)) continue;
    listen_to(options_.mag_names[m], sample.mag[m], sample.t, elapsed_s, turned_s, heard_[2 + m]);
  }
}

void LiveChecks::listen_to(const std::string& name, const std::optional<Vector3>& value, double t,
                           double elapsed_s, double turned_s, Heard& heard) {
  if (value && (!heard.value || *value != *heard.value)) {
    if (heard.told) news_.push_back(fmt::format("{} measures again, from {:.1f} s on.", name, t));
    const bool counts = heard.value && !heard.told;
    const double longest_s = counts ? std::max(heard.longest_s, t - heard.new_s) : heard.longest_s;
    heard = {.new_s = t, .longest_s = longest_s, .value = value};
    return;
  }
  heard.silent_s = value ? 0.0 : heard.silent_s + elapsed_s;
  heard.turned_s += turned_s;
  if (!heard.value || heard.told) return;
  const double enough = std::max(kSilent, kSilentBefore * heard.longest_s);
  if (heard.silent_s <= enough && heard.turned_s <= enough) return;
  heard.told = true;
  news_.push_back(fmt::format(
      "{} has {} since {:.1f} s, while the other sensors go on: look at the board and its wires. "
      "What was collected until then stays.",
      name, heard.silent_s > enough ? "given no samples" : "repeated one reading", heard.new_s));
}

bool LiveChecks::due() const {
  if (since_look_ < std::clamp(in_part_ / 8, kNewAtLeast, kNewAtMost)) return false;
  const std::size_t first = std::size(kLooks);
  const double at = next_look_ < first
                        ? kLooks[next_look_]
                        : kLooks[first - 1] + kEvery * double(next_look_ - first + 1);
  return latest_s_ - begin_s_ >= at;
}

Recording LiveChecks::piece() const {
  Recording r;
  r.name = "stream";
  std::vector<std::size_t> alive;
  for (std::size_t m = 0; m < options_.mag_names.size(); ++m) {
    if (is_left_out(m)) continue;
    alive.push_back(m);
    r.mag_names.push_back(options_.mag_names[m]);
  }
  r.mag.resize(alive.size());
  r.file_units = options_.file_units;
  const auto put = [](VectorSeries& series, double t, const std::optional<Vector3>& v) {
    if (v && (series.empty() || t > series.t.back())) series.push_back(t, *v);
  };
  for (const StreamSample& s : samples_) {
    put(r.acc, s.t, s.acc);
    put(r.gyr, s.t, s.gyr);
    for (std::size_t i = 0; i < alive.size(); ++i) {
      if (alive[i] < s.mag.size()) put(r.mag[i], s.t, s.mag[alive[i]]);
    }
  }
  return r;
}

std::vector<Issue> LiveChecks::issues_in(const Recording& given) {
  Recording r = given;
  std::vector<Issue> issues = with_even_times(r);
  if (std::optional<Recording> kept = gated(r)) r = *std::move(kept);
  const double length_s = latest_s_ - samples_.front().t;
  if (length_s >= kForAbsence) {
    for (Issue& issue : absent_sensors(r)) issues.push_back(std::move(issue));
  }
  for (Issue& issue : check_recording(r)) {
    if (certain(issue, r, length_s)) issues.push_back(std::move(issue));
  }
  mounting_ = {};
  if (any_fatal(issues) || r.acc.empty() || r.gyr.empty()) return issues;
  for (VectorSeries& mag : r.mag) {
    if (mag.empty()) return issues;
  }
  mounting_ = mounting_of(std::move(r), issues);
  if (!sure(mounting_, length_s)) mounting_ = {};
  for (Issue& issue : axes_issues()) issues.push_back(std::move(issue));
  return issues;
}

void LiveChecks::look() {
  if (samples_.size() < std::size_t(kNewAtLeast) || since_look_ == 0) return;
  since_look_ = 0;
  const double elapsed = latest_s_ - begin_s_;
  next_look_ = std::size_t(std::ranges::upper_bound(kLooks, elapsed) - std::begin(kLooks));
  if (next_look_ == std::size(kLooks)) {
    next_look_ += std::size_t((elapsed - kLooks[next_look_ - 1]) / kEvery);
  }
  const Recording r = piece();
  if (r.acc.empty() && r.gyr.empty() &&
      std::ranges::all_of(r.mag, [](const VectorSeries& s) { return s.empty(); })) {
    return;
  }
  std::vector<Issue> seen = without_doubles(issues_in(r));
  leave_out_dead(seen);
  go_on_without_hung(seen);
  take_back(seen);
  // A fatal fault may be the cause of all others.
  const bool fatal = any_fatal(seen);
  for (const Issue& issue : seen) {
    if (!fatal || issue.severity == Severity::kFatal) see(issue);
  }
  rank();
}

// Whether the issue's sensor, or its axis, gave other readings before.
bool LiveChecks::has_measured(const Issue& issue) const {
  std::vector<std::string> names{"acc", "gyr"};
  names.insert(names.end(), options_.mag_names.begin(), options_.mag_names.end());
  const auto at = std::ranges::find(names, issue.sensor);
  if (at == names.end()) return false;
  const std::array<long, 3>& changes = readings_[std::size_t(at - names.begin())].changes;
  if (issue.axis >= 0) return changes[std::size_t(issue.axis)] >= kHasMeasured;
  return *std::ranges::max_element(changes) >= kHasMeasured;
}

// Magnetometers of an array that never measured, as no reading of an axis was another than the one
// before, or two axes are one.
void LiveChecks::leave_out_dead(std::vector<Issue>& seen) {
  left_out_.resize(options_.mag_names.size());
  std::map<std::size_t, Issue> dead;
  std::size_t alive = 0;
  for (std::size_t m = 0; m < left_out_.size(); ++m) {
    if (is_left_out(m)) continue;
    const auto fatal = std::ranges::find_if(seen, [&](const Issue& issue) {
      if (issue.sensor != options_.mag_names[m]) return false;
      return issue.kind == "absent" || (issue.severity == Severity::kFatal &&
                                        is_any_of(issue.kind, {"constant", "copied", "set_aside"}));
    });
    if (fatal == seen.end() || (fatal->kind != "copied" && has_measured(*fatal))) {
      ++alive;
    } else {
      dead.emplace(m, *fatal);
    }
  }
  if (alive == 0) return;
  for (const auto& [m, issue] : dead) {
    left_out_[m] = 1;
    const auto of_it = [&name = issue.sensor](const Issue& i) { return i.sensor == name; };
    std::erase_if(seen, of_it);
    std::erase_if(found_, [&](const Found& f) { return of_it(f.issue); });
    left_out_issues_.push_back({"left_out", issue.sensor, -1, Severity::kCaution, 0.0, 0.0,
                                left_out_sentence(issue.sensor, issue.problem), issue.remedy});
  }
  seen.insert(seen.end(), left_out_issues_.begin(), left_out_issues_.end());
}

// A sensor that has measured and does so no more: what came before is as good as ever. (listen()
// tells of it.)
void LiveChecks::go_on_without_hung(std::vector<Issue>& seen) const {
  std::erase_if(seen, [&](const Issue& i) { return i.kind == "constant" && has_measured(i); });
  for (Issue& issue : seen) {
    if (issue.kind != "set_aside" || issue.severity != Severity::kFatal) continue;
    if (has_measured(issue)) issue.severity = Severity::kCaution;
  }
}

void LiveChecks::see(const Issue& issue) {
  const double first_s = samples_.front().t;
  const auto before =
      std::ranges::find_if(found_, [&](const Found& f) { return same(f.issue, issue); });
  const bool said_elsewhere =
      issue.kind == "set_aside" && options_.set_aside_is_said && issue.severity != Severity::kFatal;
  if (before == found_.end()) {
    found_.push_back({issue, first_s});
    if (!said_elsewhere) news_.push_back(capitalised(issue.text()));
    return;
  }
  const bool graver =
      issue.severity > before->issue.severity ||
      (!named_option(issue).empty() && named_option(issue) != named_option(before->issue));
  if (graver && !said_elsewhere) news_.push_back(capitalised(issue.text()));
  // A graver fault found before stands, unless the same samples and later ones now show a lesser
  // one.
  if (issue.severity >= before->issue.severity || first_s <= before->first_s) {
    *before = {issue, first_s};
  }
}

void LiveChecks::take_back(const std::vector<Issue>& seen) {
  const bool fatal = any_fatal(seen);
  std::erase_if(found_, [&](const Found& f) {
    const Issue& issue = f.issue;
    const bool still = std::ranges::any_of(seen, [&](const Issue& s) { return same(s, issue); });
    // With more samples the gate may give another reason for setting the same ones aside.
    const bool otherwise = issue.kind == "set_aside" && samples_.front().t <= f.first_s;
    if (!still && otherwise) return true;
    // Take back only what was looked at again with more samples. A motion that shows nothing takes
    // nothing back.
    if (still || has_place(issue) || samples_.front().t > f.first_s) return false;
    if (fatal && issue.severity != Severity::kFatal) return false;
    if (issue.kind == "axes" && mounting_.status == MountingStatus::kUndecided) return false;
    news_.push_back(fmt::format("Taken back, after {:.0f} s of data: {}.", latest_s_ - begin_s_,
                                issue.problem));
    return true;
  });
}

void LiveChecks::judge(const Calibration& estimate) {
  if (options_.dip_sign == 0 || samples_.empty() || estimate.fields.empty()) return;
  const double dip = estimate.parameters.dip_rad;
  // As in check_axes.h, the sign of a flat dip is not known.
  const double sigma =
      std::max(estimate.fields.front().dip_sigma_rad, kFlatDip_deg / kDipKnown * M_PI / 180.0);
  dip_rad_ = std::abs(dip) > kDipKnown * sigma ? std::optional(dip) : std::nullopt;
  if (!dip_rad_) return;
  const std::vector<Issue> seen = axes_issues();
  for (const Issue& issue : seen) see(issue);
  rank();
}

// Issues of the mounting. The sign of the dip, where it is known, distinguishes a turned
// magnetometer from an inverted one.
std::vector<Issue> LiveChecks::axes_issues() const {
  std::size_t m = 0;
  while (is_left_out(m)) ++m;
  const std::string& first = options_.mag_names[m];
  std::vector<Issue> out;
  out = axes_that_do_not_fit(mounting_);
  const bool wrong_sign = dip_rad_ && *dip_rad_ * options_.dip_sign < 0.0;
  std::vector<AxesFinding> findings = mounting_.findings;
  if (mounting_.status == MountingStatus::kUndecided) findings = likely_findings(mounting_);
  for (const AxesFinding& f : findings) {
    const bool imu = f.sensor == "acc" || f.sensor == "gyr";
    out.push_back({"axes", f.sensor, -1, imu ? Severity::kFatal : Severity::kCaution, 0.0, 0.0,
                   f.problem, f.text_of_remedy});
    if (imu || !f.or_inverted || !dip_rad_) continue;
    out.back().remedy = fmt::format("give --axes {}={}", f.sensor,
                                    axes_text(wrong_sign ? Matrix3(-f.remedy) : f.remedy));
  }
  if (mounting_.status == MountingStatus::kConsistent && wrong_sign) {
    out.push_back(
        {"axes", first, -1, Severity::kCaution, 0.0, 0.0,
         fmt::format("the dip of {:+.0f} deg is that of the {} hemisphere, which yours is not: an "
                     "odd number of the magnetometer's axes (or all of the accelerometer's) are "
                     "inverted",
                     *dip_rad_ * 180.0 / M_PI, *dip_rad_ > 0.0 ? "northern" : "southern"),
         fmt::format("if it is all three of the magnetometer's, give --axes {}=-x,-y,-z", first)});
  }
  return out;
}

void LiveChecks::rank() {
  issues_.clear();
  for (const Found& f : found_) issues_.push_back(f.issue);
  std::ranges::stable_sort(issues_,
                           [](const Issue& a, const Issue& b) { return a.severity > b.severity; });
}

std::vector<std::string> LiveChecks::take_news() { return std::exchange(news_, {}); }

const Issue* LiveChecks::fatal() const {
  const bool any = !issues_.empty() && issues_.front().severity == Severity::kFatal;
  return any ? &issues_.front() : nullptr;
}

std::vector<KnownFault> LiveChecks::faults() const {
  std::vector<KnownFault> out;
  for (const Issue& issue : issues_) {
    // What a whole calibration says of them itself is not said twice.
    const bool said = issue.kind == "set_aside" && options_.set_aside_is_said;
    if (damages(issue) && issue.kind != "axes" && !said)
      out.push_back(known_fault("stream", issue));
  }
  return out;
}

std::string LiveChecks::explanation(double begin_s, double end_s) {
  look();
  // A fault that was there all the time does not explain a sudden misfit, unless it is fatal.
  const auto explains = [&](const Issue& issue, bool mag) {
    if (issue.sensor.starts_with("mag") != mag) return false;
    if (!has_place(issue)) return issue.severity == Severity::kFatal;
    const bool there = issue.end_s > begin_s - kNearby && issue.begin_s < end_s + kNearby;
    return there && (damages(issue) || issue.kind == "set_aside");
  };
  for (const bool mag : {true, false}) {
    for (const Issue& issue : issues_) {
      if (explains(issue, mag)) return issue.problem;
    }
  }
  return "";
}

}  // namespace magimu

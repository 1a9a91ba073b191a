// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/live/live_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "calibration/trust/check_axes.h"
#include "calibration/trust/field_check.h"
#include "recording/checks/gate.h"
#include "recording/checks/repeats.h"
#include "recording/data/arrival_stamps.h"
#include "recording/data/axes.h"
#include "recording/data/parts.h"
#include "recording/data/row_times.h"
#include "recording/data/units.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

// s of data; then every kEvery.
constexpr double kLooks[] = {2.0, 3.0, 4.0, 4.8, 6.5, 8.0, 10.0, 12.0, 15.0, 20.0, 30.0};
constexpr double kEvery = 30.0;  // s
// What is kept: a minute, at least some samples (a time in a wrong unit), at most some (memory).
constexpr double kKept = 60.0;  // s
constexpr std::size_t kKeptAtLeast = 400, kKeptAtMost = 60000;
// New samples before the next look: an eighth of all so far, so that a wrong clock costs no more
// than a right one.
constexpr long kNewAtLeast = 20, kNewAtMost = 500;
// s of data before what is said of a whole recording can be said of its beginning: rates and
// spreads, from some hundred intervals; where sensors begin and end, as a tenth of the whole.
constexpr double kForRates = 4.0, kForSpans = 15.0, kForAbsence = 4.0, kForUnits = 15.0;
// Sum of all turns from which on the magnetometer's range tells a unit that has no name.
constexpr double kTurnedEnoughToTell = M_PI;
constexpr double kTurnedRate = 0.2;    // rad/s, mean: the sensor is being turned
constexpr double kChangedShare = 0.3;  // of the usual reading, by which turning changes one
// Rows of slower sensors come late by less; after a longer gap, or a reset, a new part begins.
constexpr double kLate = 1.0, kOtherPart = kPartGap - 1.0;  // s
constexpr double kDipKnown = 5.0;  // standard deviations of a dip whose sign counts
constexpr double kNearby = 1.0;    // s around windows, in which a fault explains them

bool has_place(const Issue& issue) { return issue.begin_s != 0.0 || issue.end_s != 0.0; }

bool any_fatal(const std::vector<Issue>& issues) {
  return std::ranges::any_of(issues,
                             [](const Issue& issue) { return issue.severity == Severity::kFatal; });
}

bool is_any_of(const std::string& kind, std::initializer_list<const char*> kinds) {
  return std::ranges::any_of(kinds, [&](const char* k) { return kind == k; });
}

bool same(const Issue& a, const Issue& b) {
  // What is set aside for different reasons has different remedies.
  return a.kind == b.kind && a.sensor == b.sensor && a.axis == b.axis &&
         (a.kind != "set_aside" || a.remedy == b.remedy);
}

// The gravest of each.
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

// The unit or the axes that a remedy names; empty where it is a number, which changes with every
// look.
std::string named_option(const Issue& issue) {
  if (!is_any_of(issue.kind, {"axes", "unit"})) return "";
  const std::size_t at = issue.remedy.find('=');
  if (at == std::string::npos || at + 1 >= issue.remedy.size()) return "";
  const char first = issue.remedy[at + 1];
  const bool name = std::isalpha(static_cast<unsigned char>(first)) != 0 || first == '-';
  return name ? issue.remedy : "";
}

bool changes(const VectorSeries& s) {
  if (s.empty()) return false;
  Vector3 low = s.v.front(), high = low;
  double usual = 0.0;
  for (const Vector3& v : s.v) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
    usual += v.norm() / double(s.size());
  }
  return (high - low).norm() > kChangedShare * usual;
}

bool is_turned(const Recording& r) {
  double rate = 0.0;
  for (const Vector3& v : r.gyr.v) rate += v.norm() / double(r.gyr.size());
  return rate > kTurnedRate || changes(r.acc) || std::ranges::any_of(r.mag, changes);
}

double turns_of(const VectorSeries& gyr) {
  double sum = 0.0;
  for (std::size_t k = 1; k < gyr.size(); ++k) sum += gyr.v[k].norm() * (gyr.t[k] - gyr.t[k - 1]);
  return sum;
}

double usual_length(const VectorSeries& s) {
  std::vector<double> lengths;
  for (const Vector3& v : s.v) lengths.push_back(v.norm());
  return median(std::move(lengths));
}

// The unit that a remedy gives, in the one that is given now; 0: none.
double unit_ratio(const Issue& issue, const Recording& piece) {
  const std::string quantity = issue.sensor.substr(0, 3), option = "--unit " + quantity + "=";
  const std::size_t at = issue.remedy.find(option);
  if (at == std::string::npos) return 0.0;
  const std::string rest = issue.remedy.substr(at + option.size());
  const auto given = piece.file_units.find(quantity);
  return unit_in_ours(quantity, rest.substr(0, rest.find(' '))).value_or(0.0) /
         (given == piece.file_units.end() ? 1.0 : given->second);
}

// Of a few seconds.
bool certain_unit(const Issue& issue, const Recording& piece, double length_s) {
  if (length_s >= kForUnits) return true;
  const bool named = !named_option(issue).empty();
  if (issue.sensor.starts_with("mag")) return named || turns_of(piece.gyr) > kTurnedEnoughToTell;
  const double ratio = unit_ratio(issue, piece);
  // A hand that shakes the board makes much of gravity, but hardly 16 g.
  if (issue.sensor == "acc") return named || ratio < 1.0 / 16.0;
  // Noise, and accelerations, turn directions: a gyroscope may seem to read too little; and the few
  // turns at the beginning are known to a factor of two.
  return named || ratio < 0.25;
}

// Whether what was found in a piece of length_s seconds will be found in a longer one.
bool certain(const Issue& issue, const Recording& piece, double length_s) {
  if (issue.severity == Severity::kNote) {
    const bool clipped =
        issue.kind == "set_aside" && issue.problem.find("clipped") != std::string::npos;
    if (issue.kind != "repeats") return clipped;
  }
  // At rest a coarse converter repeats itself.
  if (issue.kind == "repeats" && !is_turned(piece)) return false;
  if (issue.kind == "constant" || issue.kind == "copied") return is_turned(piece);
  if (issue.kind == "unit") return certain_unit(issue, piece, length_s);
  // A hand that swings the board halves gravity, but not for long.
  if (issue.kind == "gravity") return length_s >= kForUnits || usual_length(piece.acc) < 2.0;
  // A sphere through all attitudes: a minute hardly has them.
  if (issue.kind == "acc_scale") return false;
  if (issue.kind == "span") return length_s >= kForSpans;
  if (is_any_of(issue.kind, {"jitter", "interpolation", "repeats", "field_size"})) {
    return length_s >= kForRates;
  }
  return true;
}

// Samples stamped on arrival get even times, as a file's do (row_times.h), and one issue for all of
// them.
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

// As calibrate() looks at the axes: without repeats of slower sensors, in the parts that gaps make.
Mounting mounting_of(Recording r, const std::vector<Issue>& issues) {
  for (std::size_t m = 0; m < r.mag.size(); ++m) {
    const bool repeats = std::ranges::any_of(issues, [&](const Issue& issue) {
      return issue.kind == "repeats" && issue.sensor == r.mag_names[m];
    });
    if (repeats) r.mag[m] = without_repeats(r.mag[m]);
  }
  std::vector<std::string> ignored;
  const std::optional<std::vector<Recording>> parts = parts_of(r, ignored);
  if (!parts) return check_mounting(r);
  std::vector<const Recording*> all;
  for (const Recording& part : *parts) all.push_back(&part);
  return all.empty() ? Mounting() : check_mounting(all);
}

// Of less than a dozen seconds the pairs of directions that mounting.h compares are few and close:
// a hand's accelerations may make wrong axes fit better than the right ones. Two root mean squares
// of twelve pairs differ by a factor of four in a few of a million cases (F distribution); wrong
// axes differ by the turns themselves, tens of degrees against a few.
constexpr double kClearly = 4.0;

// How much better the best axes fit than the axes as they are, as a factor; of sensors that say the
// same of the gyroscope all together, since what misleads one does not mislead the other.
double clearness(const AxesFit& fit, const std::vector<AxesFit>& all) {
  double product = 1.0;
  for (const AxesFit& other : all) {
    if (other.gyr_axes.empty() || other.may_be_straight()) continue;
    if (other.gyr_axes.front() == fit.gyr_axes.front()) {
      product *= other.rms_straight_rad / std::max(1e-9, other.rms_rad);
    }
  }
  return product;
}

bool sure(const Mounting& mounting, double length_s) {
  constexpr double kWhole = 24.0;  // s, from which on mounting.h has pairs of its usual distance
  return length_s >= kWhole || std::ranges::all_of(mounting.fits, [&](const AxesFit& fit) {
           if (fit.may_be_straight()) return true;
           if (fit.gyr_axes.empty()) return fit.rms_straight_rad > kClearly * fit.rms_rad;
           return clearness(fit, mounting.fits) > kClearly;
         });
}

// Before the motion tells which axes are meant, it may tell that they are not what they are taken
// for.
std::vector<Issue> axes_that_do_not_fit(const Mounting& mounting) {
  std::vector<Issue> out;
  if (mounting.status != MountingStatus::kUndecided || !likely_findings(mounting).empty())
    return out;
  for (const AxesFit& fit : mounting.fits) {
    // The field's directions are known once the sensor was turned to all sides.
    const bool clearly = fit.rms_straight_rad > kClearly * fit.rms_rad && fit.sensor == "acc";
    if (fit.gyr_axes.empty() || fit.may_be_straight() || !clearly) continue;
    std::string so_far;
    for (const AxesFinding& f : findings_so_far(mounting)) {
      if (f.sensor == fit.sensor) so_far = "; so far this fits best: " + f.text_of_remedy;
    }
    out.push_back(
        {"axes", fit.sensor, -1, Severity::kCaution, 0.0, 0.0,
         fmt::format("the directions of {} do not turn as the gyroscope says: the axes of "
                     "one of them are others",
                     fit.sensor),
         "turn it about all three of its axes, and the option that mends it is certain" + so_far});
  }
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
  // (Times in a wrong unit are further apart than that: they shall be looked at.)
  const bool gap = sample.t > latest_s_ + kOtherPart && in_part_ >= kNewAtLeast;
  if (samples_.empty() || sample.t < latest_s_ - kLate || gap) {
    samples_.clear();
    begin_s_ = latest_s_ = sample.t;
    in_part_ = since_look_ = 0;
    next_look_ = 0;
  }
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
  r.mag_names = options_.mag_names;
  r.mag.resize(r.mag_names.size());
  r.file_units = options_.file_units;
  const auto put = [](VectorSeries& series, double t, const std::optional<Vector3>& v) {
    if (v && (series.empty() || t > series.t.back())) series.push_back(t, *v);
  };
  for (const StreamSample& s : samples_) {
    put(r.acc, s.t, s.acc);
    put(r.gyr, s.t, s.gyr);
    for (std::size_t m = 0; m < std::min(s.mag.size(), r.mag.size()); ++m) {
      put(r.mag[m], s.t, s.mag[m]);
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
  const std::vector<Issue> seen = without_doubles(issues_in(r));
  take_back(seen);
  // Where something is fatal, the rest may follow from it.
  const bool fatal = any_fatal(seen);
  for (const Issue& issue : seen) {
    if (!fatal || issue.severity == Severity::kFatal) see(issue);
  }
  rank();
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
  // A graver fault before stands, unless the same samples with more behind them say otherwise.
  if (issue.severity >= before->issue.severity || first_s <= before->first_s) {
    *before = {issue, first_s};
  }
}

void LiveChecks::take_back(const std::vector<Issue>& seen) {
  const bool fatal = any_fatal(seen);
  std::erase_if(found_, [&](const Found& f) {
    const Issue& issue = f.issue;
    const bool still = std::ranges::any_of(seen, [&](const Issue& s) { return same(s, issue); });
    // With more samples the gate has found another reason to set these aside.
    const bool otherwise = issue.kind == "set_aside" && samples_.front().t <= f.first_s;
    if (!still && otherwise) return true;
    // Only what was looked at again, and more: a motion that tells nothing takes nothing back.
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
  // As check_axes.h: a flat dip tells nothing.
  const double sigma =
      std::max(estimate.fields.front().dip_sigma_rad, kFlatDip_deg / kDipKnown * M_PI / 180.0);
  dip_rad_ = std::abs(dip) > kDipKnown * sigma ? std::optional(dip) : std::nullopt;
  if (!dip_rad_) return;
  const std::vector<Issue> seen = axes_issues();
  for (const Issue& issue : seen) see(issue);
  rank();
}

// Of the mounting, and of the sign of the dip where it is known, which tells a magnetometer that is
// turned from one that is inverted.
std::vector<Issue> LiveChecks::axes_issues() const {
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
        {"axes", options_.mag_names.front(), -1, Severity::kCaution, 0.0, 0.0,
         fmt::format("the dip of {:+.0f} deg is that of the {} hemisphere, which yours is not: an "
                     "odd number of the magnetometer's axes (or all of the accelerometer's) are "
                     "inverted",
                     *dip_rad_ * 180.0 / M_PI, *dip_rad_ > 0.0 ? "northern" : "southern"),
         fmt::format("if it is all three of the magnetometer's, give --axes {}=-x,-y,-z",
                     options_.mag_names.front())});
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
    if (damages(issue) && issue.kind != "axes") out.push_back(known_fault("stream", issue));
  }
  return out;
}

std::string LiveChecks::explanation(double begin_s, double end_s) {
  look();
  // What has been there all the time explains no sudden misfit, unless nothing fits with it.
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

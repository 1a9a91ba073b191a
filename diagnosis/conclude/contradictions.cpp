// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conclude/contradictions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "calibration/motion/rests/rests.h"
#include "diagnosis/conclude/unexplained.h"
#include "diagnosis/noise/noise_causes.h"
#include "diagnosis/result/sentence_words.h"
#include "diagnosis/search/option.h"
#include "factors/effects/change.h"
#include "factors/sensor_model.h"
#include "recording/checks/quality.h"
#include "recording/oddities/dead_zone.h"

namespace magimu {
namespace {

constexpr double kNear = 0.25;   // of an interval, to a convention; farther it is a filter's delay
constexpr double kSigmas = 3.0;  // standard deviations within which two times, or lags, are equal
// Of the nats that a gyroscope's delay explains: what its low-pass does besides. Beside its delay
// the phase of a Butterworth filter of second order is off by x^2 / 3 of the delay's, x the
// motion's frequency over the filter's; nats go with the square, and x is below one half.
constexpr double kRestOfFilter = 0.01;

// The check that speaks against the times of a recording's gyroscope or magnetometer; empty: none.
std::string bad_times(const std::vector<const Recording*>& given) {
  for (const Recording* r : given) {
    for (const Issue& issue : check_recording(*r)) {
      const bool of_times = issue.kind == "jitter" || issue.kind == "repeats";
      if (of_times && issue.severity != Severity::kNote && issue.sensor != "acc") {
        return issue.problem;
      }
    }
  }
  return "";
}

// A clock that is off by a fraction of a per cent cannot be told from times that are wrong one by
// one: the mean of their errors looks like a wrong rate.
void withdraw_clock_of_bad_times(const std::vector<const Recording*>& given, Diagnosis& d) {
  const auto clock = std::ranges::find(d.findings, "clock_scale", &Finding::effect);
  if (clock == d.findings.end()) return;
  const std::string bad = bad_times(given);
  if (bad.empty()) return;
  add_evidence(d, Sensor::kGyr,
               fmt::format("The times fit a clock that is wrong by {:.2g} %, but {}: whether the "
                           "clock is right these times do not tell, and it is not named.",
                           100.0 * std::abs(clock->parameters.front().value), bad));
  d.findings.erase(clock);
}

// Where rows of two devices are mixed, what the readings of the mixture show is the mixture.
void withdraw_of_mixtures(const std::vector<const Recording*>& given, Diagnosis& d) {
  for (const Recording* r : given) {
    for (const Issue& issue : check_recording(*r)) {
      if (issue.kind != "mixed") continue;
      std::erase_if(d.findings, [&](const Finding& f) { return f.channel == issue.sensor; });
      add_evidence(d, sensor_named(issue.sensor),
                   fmt::format("{}{}. Nothing else is named of such samples; {}.",
                               char(std::toupper(issue.problem.front())), issue.problem.substr(1),
                               issue.remedy));
    }
  }
}

// A change whose beginning and end are closer than their uncertainties is no change: something came
// and went.
void withdraw_what_passed(Diagnosis& d) {
  constexpr double kToldApart = 3.0;  // standard deviations
  for (auto f = d.findings.begin(); f != d.findings.end();) {
    const auto of = [&](const char* name) {
      const auto it = std::ranges::find(f->parameters, name, &FoundParameter::name);
      return it != f->parameters.end() ? *it : FoundParameter{};
    };
    const FoundParameter t0 = of("t0"), t1 = of("t1");
    const bool both = is_change(f->effect) && std::isfinite(t0.value) && std::isfinite(t1.value);
    if (!both || t1.value - t0.value > kToldApart * std::hypot(t0.sigma, t1.sigma)) {
      ++f;
      continue;
    }
    const Sensor channel = sensor_named(f->channel);
    add_evidence(
        d, channel,
        fmt::format("About {:.1f} s, for some {:.1f} s, the {} departs from the model, and "
                    "neither begins nor ends at once, as a change does{}",
                    0.5 * (t0.value + t1.value), t1.value - t0.value, in_words(channel),
                    channel == Sensor::kMag ? ": something passed it?" : "."));
    f = d.findings.erase(f);
  }
}

// The mean over which interval a gyroscope's sample is: read wrongly, the attitude comes half an
// interval or a whole one late, and the magnetometer seems ahead by as much. (A magnetometer that
// is truly ahead would have to show what is to come.)
void name_interval_convention(const std::vector<const Recording*>& given, bool gyr_is_late,
                              Diagnosis& d) {
  struct Convention {
    const char* option;
    double intervals;
  };
  constexpr Convention kConventions[] = {{"centred", 0.5}, {"backward", 1.0}};
  for (Finding& f : d.findings) {
    if (f.effect != "mag_time_offset" || f.parameters.empty()) continue;
    const double ahead = -f.parameters[0].value, sigma = f.parameters[0].sigma;
    const double interval = 1.0 / given.front()->gyr.rate_hz();
    if (!(ahead > 0.0) || ahead > (1.0 + kNear) * interval + kSigmas * sigma) continue;
    // The nearest of the two: what lies between is a filter's delay besides.
    const Convention& c = std::abs(ahead - 0.5 * interval) < std::abs(ahead - interval)
                              ? kConventions[0]
                              : kConventions[1];
    // Can these data tell the convention from none?
    const double beside = ahead - c.intervals * interval;
    const bool plain = std::abs(beside) < std::max(kNear * interval, kSigmas * sigma);
    if (!plain) continue;
    const bool exactly = std::abs(beside) < kSigmas * sigma;
    const std::string amount =
        c.intervals < 1.0 ? "half a gyroscope interval" : "one gyroscope interval";
    if (gyr_is_late && !exactly) {
      f.sentence += fmt::format(
          " If its samples are the mean over another interval than assumed (--gyro-interval {}), "
          "{} of it, {:.2f} ms, is that.",
          c.option, amount, 1e3 * c.intervals * interval);
      continue;
    }
    const bool possible = 0.5 * interval < kSigmas * sigma;  // either would do, and none
    f.sentence = fmt::format(
        "The gyroscope's rates {} about {} late ({:.2f} +- {:.2f} ms): {} the mean over another "
        "interval than assumed? State it (--gyro-interval {}) and look what is left.",
        possible ? "may come" : "come", amount, 1e3 * ahead, 1e3 * sigma,
        possible ? "are its samples perhaps" : "are its samples", c.option);
    if (exactly) continue;
    f.sentence += fmt::format(
        " That is {:.2f} ms {} than {}, which no convention makes: a filter of the gyroscope, or "
        "its times.",
        1e3 * std::abs(beside), beside > 0.0 ? "more" : "less", amount);
  }
}

// Against a gyroscope that is late, by its low-pass or by its times, the two others are ahead
// alike: the findings that say so, the magnetometer's first. Null: it is not.
std::pair<Finding*, Finding*> late_gyroscope(Diagnosis& d) {
  const auto mag = std::ranges::find(d.findings, "mag_time_offset", &Finding::effect);
  const auto acc = std::ranges::find(d.findings, "acc_time_offset", &Finding::effect);
  if (mag == d.findings.end() || acc == d.findings.end()) return {};
  if (mag->parameters.empty() || acc->parameters.empty()) return {};
  const FoundParameter &one = mag->parameters[0], &other = acc->parameters[0];
  const auto ahead = [](const FoundParameter& tau) { return -tau.value > kSigmas * tau.sigma; };
  if (!ahead(one) || !ahead(other)) return {};
  // The rest of a filter moves both, by the share of the delay whose square is its share of nats.
  const double alike = std::max(kSigmas * std::hypot(one.sigma, other.sigma),
                                std::sqrt(kRestOfFilter) * std::abs(one.value));
  if (std::abs(one.value - other.value) > alike) return {};
  return {&*mag, &*acc};
}

bool name_late_gyroscope(Diagnosis& d) {
  const auto [mag, acc] = late_gyroscope(d);
  if (mag == nullptr) return false;
  const FoundParameter &one = mag->parameters[0], &other = acc->parameters[0];
  mag->sentence = fmt::format(
      "The gyroscope's rates come late, by {:.2f} +- {:.2f} ms against the magnetometer and by "
      "{:.2f} +- {:.2f} ms against the accelerometer: these agree, so it is the gyroscope that is "
      "late, by a low-pass of its own or by its samples' times. Widen its filter, or give its "
      "samples earlier times.",
      -1e3 * one.value, 1e3 * one.sigma, -1e3 * other.value, 1e3 * other.sigma);
  acc->sentence = fmt::format(
      "The accelerometer is ahead of the gyroscope by {:.2f} +- {:.2f} ms, as the magnetometer is: "
      "it is the gyroscope that is late.",
      -1e3 * other.value, 1e3 * other.sigma);
  return true;
}

// A low-pass does more than delay, and no model here has that of a gyroscope: what was found beside
// the delay and is worth only crumbs of it may be the rest of the filter.
void withdraw_crumbs_of_a_filter(Diagnosis& d) {
  const auto [mag, acc] = late_gyroscope(d);
  if (mag == nullptr) return;
  const auto nats = [](const Finding& f) {
    return f.gain.heldout_nll_before - f.gain.heldout_nll_after;
  };
  const double crumb = kRestOfFilter * (nats(*mag) + nats(*acc));
  std::vector<std::string> withdrawn;
  std::erase_if(d.findings, [&](const Finding& f) {
    const bool is_delay = f.effect == "mag_time_offset" || f.effect == "acc_time_offset";
    // A filter acts alike all along: what begins, ends or drifts is none.
    const std::shared_ptr<const Effect> effect = find_effect(f.effect);
    const bool crumbs = !is_delay && effect != nullptr && lasts(*effect) && nats(f) < crumb;
    if (crumbs) withdrawn.push_back(fmt::format("\"{}\"", effect_words(f.effect)));
    return crumbs;
  });
  if (withdrawn.empty()) return;
  d.notes.push_back(
      fmt::format("What would pass for {} is worth less than {:.0f} % of the gyroscope's delay: "
                  "what a low-pass does beside delaying looks like that, so it is not named.",
                  fmt::join(withdrawn, ", "), 100.0 * kRestOfFilter));
}

// Beside a clock of its own the offset is what its samples' ages leave, and may be negative.
void name_age_beside_clock(Diagnosis& d) {
  const auto offset = std::ranges::find(d.findings, "mag_time_offset", &Finding::effect);
  const auto clock = std::ranges::find(d.findings, "mag_own_clock", &Finding::effect);
  if (offset == d.findings.end() || clock == d.findings.end()) return;
  if (offset->parameters.empty() || clock->parameters.empty()) return;
  const FoundParameter& tau = offset->parameters[0];
  const double age = tau.value + 0.5 * clock->parameters[0].value;
  offset->sentence = fmt::format(
      "The magnetometer's samples are {:.2f} +- {:.2f} ms {} on the average: {:.2f} ms beside what "
      "its own clock (below) makes of them.",
      1e3 * std::abs(age), 1e3 * tau.sigma, age > 0.0 ? "late" : "early", 1e3 * tau.value);
}

// What the magnetometer averages shows in the residuals as its own clock does, and so does a lag;
// with that clock in the model they may be nothing.
void withdraw_what_the_clock_explains(Diagnosis& d) {
  constexpr double kNothing = 2.0;  // standard deviations
  if (std::ranges::count(d.findings, "mag_own_clock", &Finding::effect) == 0) return;
  std::erase_if(d.findings, [](const Finding& f) {
    return (f.effect == "mag_bandwidth" || is_lag(f.effect)) && !f.parameters.empty() &&
           std::abs(f.parameters[0].value) < kNothing * f.parameters[0].sigma;
  });
}

// Which time a sample is given is a convention: half an interval before or after is no fault of the
// accelerometer's.
void name_acc_convention(const std::vector<const Recording*>& given, Diagnosis& d) {
  for (Finding& f : d.findings) {
    if (f.effect != "acc_time_offset" || f.parameters.empty()) continue;
    const double late = std::abs(f.parameters[0].value), sigma = f.parameters[0].sigma;
    const double half = 0.5 / given.front()->acc.rate_hz();
    if (std::abs(late - half) > std::max(kNear * half, kSigmas * sigma)) continue;
    f.sentence = fmt::format(
        "The accelerometer {} the gyroscope by half a sampling interval ({:.2f} +- {:.2f} ms): are "
        "the samples of one of them means over an interval, given the time of its middle or its "
        "end?",
        f.parameters[0].value < 0.0 ? "is ahead of" : "lags", 1e3 * late, 1e3 * sigma);
  }
}

// Nothing passes a resting sensor, and in rest the device's own field and the place's look alike.
void name_change_at_rest(const std::vector<const Recording*>& given, Diagnosis& d) {
  for (Finding& f : d.findings) {
    const bool of_field = f.effect == "field_change";
    if ((f.effect != "hard_iron_change" && !of_field) || f.parameters.size() < 5) continue;
    const double t0 = f.parameters[3].value, t1 = f.parameters[4].value;
    if (!std::isfinite(t0) || !std::isfinite(t1)) continue;
    for (const Recording* r : given) {
      const bool rests = std::ranges::any_of(find_rests(*r), [&](const TimeSpan& rest) {
        const double margin = RestOptions{}.window_s;
        return rest.begin_s - margin < t0 && t1 < rest.end_s + margin;
      });
      if (!rests) continue;
      f.confusable_with.insert(f.confusable_with.begin(),
                               {of_field ? "hard_iron_change" : "stationary_source",
                                "a resting sensor does not tell its own field from the place's",
                                "turn the sensor while the magnet is there"});
      if (of_field) break;
      f.sentence = fmt::format(
          "While the sensor rested, {:.1f} to {:.1f} s, the field that it read differed by "
          "[{:.2f}, "
          "{:.2f}, {:.2f}] uT from that before and after: a magnet or iron was brought near and "
          "taken away.",
          t0, t1, f.parameters[0].value, f.parameters[1].value, f.parameters[2].value);
      break;
    }
  }
}

// A change of the magnetometer's gains or mounting multiplies all that it reads, its bias too. An
// offset that is added behind them stays, which is a step of the bias at that time, and no magnet.
void name_bias_of_change(Diagnosis& d) {
  const auto change = std::ranges::find(d.findings, "mag_change", &Finding::effect);
  if (change == d.findings.end()) return;
  const auto times_of = [](const Finding& f) {
    std::vector<FoundParameter> out;
    for (const FoundParameter& p : f.parameters) {
      if ((p.name == "t0" || p.name == "t1") && std::isfinite(p.value)) out.push_back(p);
    }
    return out;
  };
  const std::vector<FoundParameter> theirs = times_of(*change);
  for (Finding& f : d.findings) {
    if (f.effect != "hard_iron_change" || f.parameters.size() < 3) continue;
    const std::vector<FoundParameter> own = times_of(f);
    const bool together = std::ranges::all_of(own, [&](const FoundParameter& t) {
      return std::ranges::any_of(theirs, [&](const FoundParameter& u) {
        return std::abs(t.value - u.value) < kSigmas * std::hypot(t.sigma, u.sigma);
      });
    });
    if (!together) continue;
    f.sentence = fmt::format(
        "At the time of that change the magnetometer's bias changed otherwise than its gains, by "
        "[{:.2f}, {:.2f}, {:.2f}] uT: an offset that is added behind them did not change with "
        "them. It is no magnet.",
        f.parameters[0].value, f.parameters[1].value, f.parameters[2].value);
  }
}

// Another strength of the field multiplies what the magnetometer reads of it alike on all axes, and
// leaves its bias; a change of the sensor's gains multiplies the bias, too.
void name_change_of_field(Diagnosis& d) {
  for (Finding& f : d.findings) {
    if (f.effect != "mag_change" || f.parameters.size() < 6 ||
        !f.parameters[0].name.ends_with("k[0]") || !f.parameters[3].name.ends_with("s[0]") ||
        d.after.parameters.mag.empty()) {
      continue;
    }
    double gain = 0.0, weight = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double w = 1.0 / std::pow(std::max(f.parameters[i].sigma, 1e-12), 2);
      gain += w * f.parameters[i].value;
      weight += w;
    }
    gain /= weight;
    const double sigma = 1.0 / std::sqrt(weight);
    bool alike = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const FoundParameter &k = f.parameters[i], &s = f.parameters[3 + i];
      const double bias = d.after.parameters.mag.front().bias[Eigen::Index(i)];
      const double of_bias = d.after.sigma(fmt::format("magnetometers[0].bias[{}]", i));
      alike &= std::abs(k.value - gain) < kSigmas * k.sigma &&
               std::abs(s.value + gain * bias) <
                   kSigmas * std::hypot(s.sigma, gain * of_bias, bias * k.sigma);
    }
    if (!alike || !(std::abs(gain) > kSigmas * sigma)) continue;
    std::string when;
    for (const FoundParameter& p : f.parameters) {
      if (p.name == "t0" && std::isfinite(p.value)) when += fmt::format(" from {:.2f} s", p.value);
      if (p.name == "t1" && std::isfinite(p.value)) when += fmt::format(" until {:.2f} s", p.value);
    }
    f.sentence = fmt::format(
        "The strength of the field was another{}: by {:.3f} +- {:.3f} % ({:.2f} uT) on all axes "
        "alike, while the magnetometer's bias stayed. The field changed, or the sensor was taken "
        "to another place; its gains did not change.",
        when, 100.0 * gain, 100.0 * sigma, gain * d.after.strength_uT);
  }
}

// A field whose strength alone drifts reads as gains that drift alike on all axes, behind an offset
// that stays.
void name_drift_of_strength(Diagnosis& d) {
  const auto drift = std::ranges::find(d.findings, "field_drift", &Finding::effect);
  if (drift == d.findings.end() || d.after.parameters.mag.empty()) return;
  const Vector3 along = unit_field(d.after.parameters.dip_rad);
  double least = 0.0, most = 0.0;  // of the strength, in 1
  std::vector<double> course;
  for (std::size_t i = 0; i + 3 <= drift->parameters.size(); i += 3) {
    const auto* const p = &drift->parameters[i];
    const Vector3 c(p[0].value, p[1].value, p[2].value);
    const Vector3 across = c - along * along.dot(c);
    for (int k = 0; k < 3; ++k) {
      if (!(std::abs(across[k]) < kSigmas * p[k].sigma)) return;
    }
    course.push_back(along.dot(c));
  }
  for (double u = -1.0; u <= 1.0; u += 0.01) {
    double now = 0.0;
    for (std::size_t j = 0; j < course.size(); ++j) now += course[j] * legendre(int(j) + 1, u);
    least = std::min(least, now);
    most = std::max(most, now);
  }
  drift->sentence += fmt::format(
      " Its direction stays, and its strength changes by {:.2f} % in all: gains of the "
      "magnetometer that change alike on all axes, as where it warms up, look the same. Another "
      "magnetometer beside it would tell.",
      100.0 * (most - least));
}

}  // namespace

void name_dead_band(const std::vector<const Recording*>& given, Diagnosis& d) {
  constexpr const char* kImitated[] = {"gyro_bias_change", "gyro_bias_drift", "gyro_nonlinearity",
                                       "correlated_noise", "outliers",        "noise_scale"};
  for (const Recording* r : given) {
    const std::optional<DeadZone> zone = dead_zone_of(r->gyr);
    if (!zone) continue;
    std::erase_if(d.findings, [&](const Finding& f) {
      return f.channel == "gyr" && std::ranges::count(kImitated, f.effect) > 0;
    });
    Finding f;
    f.effect = "gyro_dead_band";
    f.channel = to_string(Sensor::kGyr);
    f.sentence = fmt::format(
        "The gyroscope has a dead band: {} it reads the same where it turns by less than some "
        "{:.2g} rad/s ({:.2g} deg/s). Slow turns are lost, and with them its bias; it does not "
        "hang.",
        zone->reads.allFinite() ? "each time" : "on an axis", zone->edge,
        zone->edge * 180.0 / M_PI);
    f.parameters = {{"band", zone->edge, 0.0, "rad/s"}};
    f.p_value = 0.0;
    f.probability = 1.0;
    f.gain = {NAN, NAN, NAN, NAN, NAN};
    d.findings.push_back(std::move(f));
    return;
  }
}

void withdraw_contradicted(const std::vector<const Recording*>& given, Diagnosis& d) {
  withdraw_clock_of_bad_times(given, d);
  withdraw_of_mixtures(given, d);
  withdraw_what_passed(d);
  withdraw_crumbs_of_a_filter(d);
  withdraw_what_the_clock_explains(d);
}

void reword_by_what_is_known(const std::vector<const Recording*>& given, Diagnosis& d) {
  const bool gyr_is_late = name_late_gyroscope(d);
  name_interval_convention(given, gyr_is_late, d);
  if (!gyr_is_late) name_acc_convention(given, d);
  name_age_beside_clock(d);
  name_change_at_rest(given, d);
  name_bias_of_change(d);
  name_change_of_field(d);
  name_drift_of_strength(d);
}

}  // namespace magimu

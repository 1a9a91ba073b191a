// SPDX-License-Identifier: BSD-3-Clause
// The requirements on a diagnosis, and whether the cases meet them (power_report.h).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "bench/power/power_report.h"
#include "statistics/quantiles.h"

namespace magimu {
namespace {

constexpr double kClear = 12.0;   // sigmas: effects of this size and above have to be found
constexpr double kLarge = 100.0;  // sigmas: from here on, further findings may gain 1 % at most
// A measured size is right to a few percent: cases count from this share of a limit on.
constexpr double kSlack = 0.95;

struct Share {
  int good = 0, all = 0;
  void add(bool is_good) {
    ++all;
    good += is_good;
  }
  double value() const { return all > 0 ? double(good) / all : 1.0; }
  std::string text() const { return fmt::format("{:.1f} % of {}", 100.0 * value(), all); }
};

class Requirements {
 public:
  std::vector<Requirement> list;

  void at_least(const std::string& what, const Share& share, double asked) {
    if (share.all == 0) return;
    list.push_back(
        {what, fmt::format(">= {:g} %", 100.0 * asked), share.text(), share.value() >= asked});
  }
  void at_most(const std::string& what, const Share& share, double asked) {
    if (share.all == 0) return;
    list.push_back(
        {what, fmt::format("<= {:g} %", 100.0 * asked), share.text(), share.value() <= asked});
  }
};

void naming(const std::vector<PowerOutcome>& outcomes, Requirements& out) {
  Share clear, pairs, parameters;
  double found = 0.0, power = 0.0;
  int small = 0;
  for (const PowerOutcome& o : outcomes) {
    const bool right = o.judgement.right();
    if (o.group == Group::kEffect && o.size >= kSlack * kClear) clear.add(right);
    if (o.group == Group::kPair && o.size >= kSlack * kClear) pairs.add(right);
    if (o.group == Group::kEffect && o.asked == 6.0) {
      ++small;
      found += right;
      power += o.allowed_power;
    }
    for (const double far : o.judgement.farthest_sigma) {
      if (!std::isnan(far) && o.size >= kSlack * kClear) parameters.add(far <= 4.0);
    }
  }
  out.at_least("named right at sizes of 12 and above", clear, 0.98);
  if (small > 0) {
    const double ratio = found / std::max(power, 1e-9);
    out.list.push_back({"named right at size 6, over what the ideal test finds", ">= 0.95",
                        fmt::format("{:.3f} ({:.0f} of {:.1f})", ratio, found, power),
                        ratio >= 0.95});
  }
  out.at_least("pairs: both named right", pairs, 0.98);
  out.at_least("parameters within 4 sigma, where named right", parameters, 0.98);
}

void nothing_there(const std::vector<PowerOutcome>& outcomes, Requirements& out) {
  std::map<std::string, Share> alarms;
  Share all, unexplained, misnamed, told;
  for (const PowerOutcome& o : outcomes) {
    const bool alarm = !o.judgement.others.empty() || o.unexplained || !o.failure.empty();
    if (o.group == Group::kNone) {
      all.add(alarm);
      alarms[o.name].add(alarm);
    }
    if (o.group == Group::kOutside && o.size >= kSlack * kClear) {
      misnamed.add(!o.judgement.others.empty());
      const std::vector<std::string> kinds = allowed_for(o.name);
      if (kinds.empty()) {
        unexplained.add(o.unexplained);
      } else {
        told.add(o.unexplained || std::ranges::any_of(kinds, [&](const std::string& kind) {
                   return o.named.find(kind) != std::string::npos;
                 }));
      }
    }
  }
  out.at_most("false alarms where nothing is hidden", all, 0.03);
  for (const auto& [noise, share] : alarms) {
    if (share.all >= 30) out.at_most("  in " + noise + " noise", share, 0.06);
  }
  out.at_least("outside of the catalogue: said to be unexplained", unexplained, 0.90);
  out.at_least("outside, kinds of noise: unexplained, or noise is named", told, 0.90);
  out.at_most("outside of the catalogue: misnamed", misnamed, 0.04);
}

void gains(const std::vector<PowerOutcome>& outcomes, Requirements& out) {
  Share spurious, second, measured;
  // Sums of squared errors of the cases of one effect at one size: single errors are a matter of
  // chance.
  struct Errors {
    double before = 0.0, after = 0.0;
  };
  std::map<std::pair<std::string, double>, Errors> biased;
  std::vector<double> growth;
  for (const PowerOutcome& o : outcomes) {
    if (o.group != Group::kEffect || !o.judgement.right()) continue;
    if (o.size >= kSlack * kLarge) spurious.add(o.judgement.others_share < 0.01);
    if (o.second_after) second.add(*o.second_after < *o.second_before);
    measured.add(o.second_after.has_value());
    if (!(o.error_after > 0.0) || !std::isfinite(o.error_before)) continue;
    if (o.bias_sigma > 2.0) {
      Errors& e = biased[{o.name, o.asked}];
      e.before += o.error_before * o.error_before;
      e.after += o.error_after * o.error_after;
    } else {
      growth.push_back(o.error_after / o.error_before);
    }
  }
  out.at_least("size 100 and above: further findings gain less than 1 % of it", spurious, 1.0);
  out.at_least("second recording measured, of named cases", measured, 1.0);
  out.at_least("second recording: its likelihood grows, of named cases", second, 0.95);
  Share falls;
  for (const auto& [key, e] : biased) falls.add(e.after < e.before);
  out.at_least("calibration's RMS error falls, effects and sizes biased > 2 sigma", falls, 1.0);
  if (growth.empty()) return;
  const double grown = median(growth);
  out.list.push_back({"calibration's error over that before, where not biased, median", "<= 1.02",
                      fmt::format("{:.3f} of {}", grown, growth.size()), grown <= 1.02});
}

void speed(const std::vector<PowerOutcome>& outcomes, Requirements& out) {
  std::vector<double> seconds;
  double most = 0.0;
  std::string slowest;
  for (const PowerOutcome& o : outcomes) {
    if (!(o.samples > 0.0) || !(o.seconds > 0.0)) continue;
    seconds.push_back(o.seconds * 18000.0 / o.samples);
    if (seconds.back() <= most) continue;
    most = seconds.back();
    slowest = fmt::format("{}, seed {}, size {:.3g}", o.name, o.seed, o.size);
  }
  if (seconds.empty()) return;
  const double s = median(seconds);
  out.list.push_back({"seconds for 180 s at 100 Hz (18,000 samples), median", "<= 1",
                      fmt::format("{:.2f} (most {:.1f}: {})", s, most, slowest), s <= 1.0});
  const auto failed = std::count_if(outcomes.begin(), outcomes.end(),
                                    [](const PowerOutcome& o) { return !o.failure.empty(); });
  out.list.push_back(
      {"cases that ended with an error", "0", fmt::format("{}", failed), failed == 0});
}

}  // namespace

std::vector<Requirement> requirements(const std::vector<PowerOutcome>& outcomes) {
  Requirements out;
  naming(outcomes, out);
  nothing_there(outcomes, out);
  gains(outcomes, out);
  speed(outcomes, out);
  return out.list;
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// Tables: power_report.h. What is asked: power_requirements.cpp.
#include "bench/power/power_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "statistics/quantiles.h"

namespace magimu {
namespace {

std::string size_name(double asked) { return asked > 0.0 ? fmt::format("{:g}", asked) : "real"; }

// Keeps the order in which they come.
using NameAndSize = std::pair<std::string, double>;
std::vector<std::pair<NameAndSize, std::vector<const PowerOutcome*>>> grouped(
    const std::vector<PowerOutcome>& outcomes, Group group) {
  std::vector<std::pair<NameAndSize, std::vector<const PowerOutcome*>>> rows;
  for (const PowerOutcome& o : outcomes) {
    if (o.group != group) continue;
    const NameAndSize key{o.name, o.asked};
    auto row =
        std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.first == key; });
    if (row == rows.end()) row = rows.insert(rows.end(), {key, {}});
    row->second.push_back(&o);
  }
  return rows;
}

struct Row {
  std::map<Naming, int> naming;
  int compared = 0, within = 0, spurious = 0, second = 0, second_better = 0;
  double power = 0.0, share = 0.0;
  std::vector<double> size, before, after, seconds;
};

Row sum(const std::vector<const PowerOutcome*>& outcomes) {
  Row row;
  for (const PowerOutcome* o : outcomes) {
    const Judgement& j = o->judgement;
    for (const Naming n : j.naming) ++row.naming[n];
    for (const double far : j.farthest_sigma) {
      row.compared += !std::isnan(far);
      row.within += far <= 4.0;
    }
    row.spurious += !j.others.empty();
    if (j.right()) row.share = std::max(row.share, j.others_share);
    row.second += o->second_after.has_value();
    row.second_better += o->second_after && *o->second_after < *o->second_before;
    row.power += o->allowed_power;
    row.size.push_back(o->size);
    if (o->error_after > 0.0) {
      row.before.push_back(o->error_before);
      row.after.push_back(o->error_after);
    }
    row.seconds.push_back(o->seconds);
  }
  return row;
}

// Not a number where there are none.
double of_some(const std::vector<double>& x) { return x.empty() ? std::nan("") : median(x); }

}  // namespace

void print_effects(const std::vector<PowerOutcome>& outcomes) {
  const auto rows = grouped(outcomes, Group::kEffect);
  if (rows.empty()) return;
  fmt::print(
      "{:<24} {:>5} {:>8} {:>3} {:>5} {:>5} {:>6} {:>5} {:>7} {:>5} {:>5} {:>7} {:>5} {:>7} "
      "{:>6} {:>7} {:>7} {:>6}\n",
      "hidden", "size", "measured", "n", "power", "right", "class", "inner", "wrong", "none",
      "unexp", "4 sigma", "more", "share", "2nd", "before", "after", "s");
  for (const auto& [key, cases] : rows) {
    Row r = sum(cases);
    fmt::print(
        "{:<24} {:>5} {:>8.3g} {:>3} {:>5.1f} {:>5} {:>6} {:>5} {:>7} {:>5} {:>5} {:>7} "
        "{:>5} {:>7.2g} {:>6} {:>7.2f} {:>7.2f} {:>6.2f}\n",
        key.first, size_name(key.second), median(r.size), cases.size(), r.power,
        r.naming[Naming::kRight], r.naming[Naming::kSameClass], r.naming[Naming::kNested],
        r.naming[Naming::kWrong], r.naming[Naming::kNothing], r.naming[Naming::kUnexplained],
        fmt::format("{}/{}", r.within, r.compared), r.spurious, r.share,
        fmt::format("{}/{}", r.second_better, r.second), of_some(r.before), of_some(r.after),
        median(r.seconds));
  }
  fmt::print(
      "power: cases that the ideal test finds. inner: as the simpler cause within it. 4 "
      "sigma: parameters right. more: cases with further findings; share: their largest "
      "gain over that of the right one. 2nd: second recordings that are predicted better. "
      "before, after: error of the calibration in sigmas, median.\n\n");
}

void print_strengths(const std::vector<PowerOutcome>& outcomes) {
  fmt::print("Strengths of the sizes, first seed (parameters as in docs/effects.md):\n");
  for (const Group group : {Group::kEffect, Group::kOutside}) {
    for (const auto& [key, cases] : grouped(outcomes, group)) {
      const PowerOutcome& o = *cases.front();
      fmt::print("  {:<24} {:>5} {:>9.4g}  {}  ({})\n", key.first, size_name(key.second), o.size,
                 o.strength, o.setting);
    }
  }
  fmt::print("\n");
}

void print_others(const std::vector<PowerOutcome>& outcomes) {
  const auto count = [](const std::vector<const PowerOutcome*>& cases, auto&& what) {
    return std::count_if(cases.begin(), cases.end(),
                         [&](const PowerOutcome* o) { return what(*o); });
  };
  const auto misnamed = [](const PowerOutcome& o) { return !o.judgement.others.empty(); };
  const auto unexplained = [](const PowerOutcome& o) { return o.unexplained; };
  for (const auto& [key, cases] : grouped(outcomes, Group::kNone)) {
    fmt::print("nothing hidden, {} noise: {} recordings, {} with a false name, {} unexplained\n",
               key.first, cases.size(), count(cases, misnamed), count(cases, unexplained));
  }
  for (const auto& [key, cases] : grouped(outcomes, Group::kOutside)) {
    fmt::print("outside: {:<20} {:>5}: {} recordings, {} unexplained, {} misnamed\n", key.first,
               size_name(key.second), cases.size(), count(cases, unexplained),
               count(cases, misnamed));
  }
  std::vector<const PowerOutcome*> pairs;
  for (const PowerOutcome& o : outcomes) {
    if (o.group == Group::kPair) pairs.push_back(&o);
  }
  if (pairs.empty()) return;
  fmt::print("pairs: {} recordings, both right {}, one {}, with further names {}\n", pairs.size(),
             count(pairs, [](const PowerOutcome& o) { return o.judgement.right(); }),
             count(pairs,
                   [](const PowerOutcome& o) {
                     const std::vector<Naming>& n = o.judgement.naming;
                     return !o.judgement.right() && std::any_of(n.begin(), n.end(), [](Naming x) {
                       return x == Naming::kRight || x == Naming::kSameClass;
                     });
                   }),
             count(pairs, misnamed));
}

void print_failures(const std::vector<PowerOutcome>& outcomes) {
  fmt::print("\nCases that are not right:\n");
  for (const PowerOutcome& o : outcomes) {
    const Judgement& j = o.judgement;
    double farthest = 0.0;
    for (const double far : j.farthest_sigma) {
      if (!std::isnan(far)) farthest = std::max(farthest, far);
    }
    const bool missed = o.group == Group::kOutside ? !o.unexplained : !j.right();
    const bool alarm = o.group == Group::kNone && o.unexplained;
    if (o.failure.empty() && !missed && !alarm && j.others.empty() && farthest <= 4.0) continue;
    fmt::print("  {:<24} {:>5} {:>8.3g} seed {:<6} named: {}", o.name, size_name(o.asked), o.size,
               o.seed, o.named);
    if (farthest > 4.0) fmt::print("; {:.3g} sigma off", farthest);
    if (!j.others.empty()) fmt::print("; share {:.2g}", j.others_share);
    if (!o.failure.empty()) fmt::print("; {}", o.failure);
    fmt::print("  [{}; {}]\n", o.strength, o.setting);
  }
}

bool print_requirements(const std::vector<PowerOutcome>& outcomes) {
  bool all = true;
  fmt::print("\n{:<66} {:>14} {:>24}\n", "what", "asked", "measured");
  for (const Requirement& r : requirements(outcomes)) {
    fmt::print("{:<66} {:>14} {:>24} {}\n", r.what, r.asked, r.measured, r.met ? "" : "MISSED");
    all = all && r.met;
  }
  return all;
}

}  // namespace magimu

// SPDX-License-Identifier: BSD-3-Clause
// Rates of the sweep against what is asked: fault_table.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "bench/faults/fault_table.h"

namespace magimu {
namespace {

using Condition = std::function<bool(const SweepRow&)>;

int count(const std::vector<SweepRow>& rows, const Condition& condition) {
  return int(std::count_if(rows.begin(), rows.end(), condition));
}

Rate rate(const std::vector<SweepRow>& rows, const std::string& what, const Condition& among,
          const Condition& bad, double most) {
  return {what, count(rows, [&](const SweepRow& r) { return among(r) && bad(r); }),
          count(rows, among), most};
}

struct Counted {
  const char* title;
  bool (*condition)(const SweepRow&);
};

constexpr Counted kCounted[] = {
    {"broke", [](const SweepRow& r) { return !r.problem.empty(); }},
    {"refused", [](const SweepRow& r) { return r.calibrate_code == 2; }},
    {"no", [](const SweepRow& r) { return r.trust == "no"; }},
    {"limited", [](const SweepRow& r) { return r.trust == "limited"; }},
    {"yes", [](const SweepRow& r) { return r.yes(); }},
    {"wrong yes", [](const SweepRow& r) { return r.yes() && r.outside; }},
    {"harmful", [](const SweepRow& r) { return r.harmful(); }},
    {"unnamed", [](const SweepRow& r) { return r.harmful() && r.named.empty(); }},
    {"harmless", [](const SweepRow& r) { return r.rich && r.harmless(); }},
    {"not yes", [](const SweepRow& r) { return r.rich && r.harmless() && !r.yes(); }},
    {"info ok", [](const SweepRow& r) { return r.false_hope(); }},
    {"predicts", [](const SweepRow& r) { return !r.contradiction.empty(); }}};

void print_kinds(const std::vector<SweepRow>& rows) {
  std::map<std::string, std::vector<SweepRow>> by_kind;
  for (const SweepRow& row : rows) by_kind[row.kind].push_back(row);
  fmt::print("{:<20} {:>5}", "fault", "runs");
  for (const Counted& c : kCounted) fmt::print(" {:>9}", c.title);
  fmt::print("\n");
  for (const auto& [kind, of] : by_kind) {
    fmt::print("{:<20} {:>5}", kind, of.size());
    for (const Counted& c : kCounted) {
      const int n = count(of, c.condition);
      fmt::print(" {:>9}", n > 0 ? fmt::format("{}", n) : "");
    }
    fmt::print("\n");
  }
}

// How bad, for the order: what broke first, then wrong answers, then silence.
double severity(const SweepRow& r) {
  if (!r.problem.empty()) return 4e9;
  if (r.yes() && r.outside) return 3e9 + std::min(9e8, r.truth_squared);
  if (!r.contradiction.empty()) return 2e9;
  if (r.harmful() && r.named.empty()) return 1e9 + std::min(9e8, r.shift_sigma);
  return r.false_hope() ? 5e8 : 0.0;
}

void print_worst(std::vector<SweepRow> rows) {
  constexpr int kEach = 2;
  std::stable_sort(rows.begin(), rows.end(),
                   [](const SweepRow& a, const SweepRow& b) { return severity(a) > severity(b); });
  std::map<std::string, int> shown;
  for (const SweepRow& r : rows) {
    if (!r.bad() || shown[r.kind]++ >= kEach) continue;
    fmt::print("\n{} ({}; {}, {}, {:g} Hz, {:g} s): {}\n", r.kind, r.what, r.source, r.motion,
               r.rate_hz, r.duration_s, complaint(r));
    fmt::print("  trust '{}' (undamaged '{}'), answer '{}', found '{}': {}\n", r.trust,
               r.clean_trust, r.answer, r.findings, r.reason);
    fmt::print("  bench_faults --only {} --first {} --count 1 --keep DIR\n", r.kind, r.index);
  }
}

}  // namespace

std::string complaint(const SweepRow& r) {
  std::string text = r.problem;
  if (r.yes() && r.outside) text += fmt::format("a wrong yes ({:.0f}). ", r.truth_squared);
  if (!r.contradiction.empty()) text += r.contradiction + ". ";
  if (r.harmful() && r.named.empty()) {
    text += fmt::format("not named, {:.1f} sigma. ", r.shift_sigma);
  }
  if (r.false_hope()) text += "info: it can be calibrated; calibrate: no. ";
  return text;
}

int binomial_95(int n, double p) {
  double term = std::pow(1.0 - p, n), sum = term;  // P(0), P(at most k)
  int k = 0;
  while (sum < 0.95 && k < n) {
    ++k;
    term *= double(n - k + 1) / double(k) * p / (1.0 - p);
    sum += term;
  }
  return k;
}

std::vector<Rate> rates(const std::vector<SweepRow>& rows) {
  const auto all = [](const SweepRow&) { return true; };
  const auto known_yes = [](const SweepRow& r) { return r.yes() && r.truth_squared >= 0.0; };
  return {
      rate(
          rows, "a crash, a limit, another exit code", all,
          [](const SweepRow& r) { return !r.problem.empty(); }, 0.0),
      rate(
          rows, "harmful (2 sigma) and not named by any command",
          [](const SweepRow& r) { return r.harmful(); },
          [](const SweepRow& r) { return r.named.empty(); }, 0.05),
      rate(
          rows, "yes, and the truth outside of the 99.9 % ellipsoid", known_yes,
          [](const SweepRow& r) { return r.outside; }, 0.01),
      rate(
          rows, "rich and harmless (0.5 sigma), and not yes",
          [](const SweepRow& r) { return r.rich && r.harmless(); },
          [](const SweepRow& r) { return !r.yes(); }, 0.10),
      rate(
          rows, "predicts in spite of evidence", all,
          [](const SweepRow& r) { return !r.contradiction.empty(); }, 0.0),
      rate(
          rows, "info permits what calibrate refuses for a reason info can see", all,
          [](const SweepRow& r) { return r.false_hope(); }, 0.0),
  };
}

bool print_rates(const std::vector<Rate>& all) {
  bool good = true;
  for (const Rate& r : all) {
    fmt::print("{:<66} {:>4} of {:>4}, at most {}: {}\n", r.what, r.count, r.of,
               binomial_95(r.of, r.most), r.holds() ? "holds" : "DOES NOT HOLD");
    good = good && r.holds();
  }
  return good;
}

bool print_summary(const std::vector<SweepRow>& rows) {
  print_worst(rows);
  fmt::print("\n");
  print_kinds(rows);
  fmt::print("\n");
  const bool good = print_rates(rates(rows));
  double seconds = 0.0, memory = 0.0;
  for (const SweepRow& r : rows) {
    seconds = std::max(seconds, r.seconds);
    memory = std::max(memory, r.memory_mb);
  }
  fmt::print("At the most {:.1f} s of processor time and {:.0f} MB.\n", seconds, memory);
  return good;
}

}  // namespace magimu

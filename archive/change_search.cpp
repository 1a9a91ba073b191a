// SPDX-License-Identifier: BSD-3-Clause
#include "archive/change_search.h"

#include <algorithm>
#include <cmath>

namespace magimu {
namespace {

// Standard deviations of one recording, log-uniform: a smaller change shows nowhere, a larger one
// needs no statistics. Walks add up, so that they matter from a smaller size on.
constexpr double kStepSizes[] = {1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0, 1024.0};
constexpr double kProcessSizes[] = {0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0};

constexpr int kMostDoublings = 30;  // beyond the grid: 1e9 times

double log_mean_exp(const std::vector<double>& logs) {
  const double most = *std::ranges::max_element(logs);
  if (!std::isfinite(most)) return most;
  double sum = 0.0;
  for (const double l : logs) sum += std::exp(l - most);
  return most + std::log(sum / double(logs.size()));
}

// exp(own) over the sum of all: 1 at most, whatever the rounding.
double share_of(double own, const std::vector<double>& logs) {
  double sum = 0.0;
  for (const double l : logs) sum += std::exp(l - own);
  return 1.0 / std::max(1.0, sum);
}

// One class of changes: its evidence over that of the model without, and its most probable member.
struct ChangeClass {
  double log_bayes_factor = 0.0;
  DeviceChange best;
  double date_probability = 1.0;
};

ChangeClass steps_of(const ChangeModel& model, double before, std::size_t group) {
  std::vector<double> all;
  std::vector<std::vector<double>> of_date;
  ChangeClass out;
  double best = -INFINITY;
  for (const double size : kStepSizes) {
    const std::vector<double> logs = model.log_evidence_with_step(group, size);
    of_date.resize(logs.size());
    for (std::size_t i = 0; i < logs.size(); ++i) {
      all.push_back(logs[i] - before);
      of_date[i].push_back(logs[i] - before);
      if (!(logs[i] > best)) continue;
      best = logs[i];
      out.best = {ChangeKind::kStep, group, i + 1, size};
    }
  }
  out.log_bayes_factor = log_mean_exp(all);
  // The date is that with the largest evidence over all sizes.
  std::vector<double> dates;
  for (const auto& logs : of_date) dates.push_back(log_mean_exp(logs));
  const auto most = std::ranges::max_element(dates);
  out.best.at = std::size_t(most - dates.begin()) + 1;
  out.date_probability = share_of(*most, dates);
  const std::vector<double>& sizes = of_date[out.best.at - 1];
  out.best.size = kStepSizes[std::ranges::max_element(sizes) - sizes.begin()];
  return out;
}

ChangeClass process_of(const ChangeProblem& problem, const std::vector<DeviceChange>& accepted,
                       double before, std::size_t group, ChangeKind kind) {
  std::vector<double> all;
  ChangeClass out;
  for (const double size : kProcessSizes) {
    std::vector<DeviceChange> changes = accepted;
    changes.push_back({kind, group, 0, size});
    all.push_back(ChangeModel(problem, changes).log_evidence() - before);
    if (all.back() >= *std::ranges::max_element(all)) out.best = changes.back();
  }
  out.log_bayes_factor = log_mean_exp(all);
  return out;
}

std::vector<ChangeClass> classes_beside(const ChangeProblem& problem,
                                        const std::vector<DeviceChange>& accepted) {
  const ChangeModel model(problem, accepted);
  const double before = model.log_evidence();
  std::vector<ChangeClass> out;
  for (std::size_t g = 0; g < problem.groups.size(); ++g) {
    out.push_back(steps_of(model, before, g));
    for (const ChangeKind kind : {ChangeKind::kWalk, ChangeKind::kTrend, ChangeKind::kScatter}) {
      const bool has = std::ranges::any_of(
          accepted, [&](const DeviceChange& c) { return c.kind == kind && c.group == g; });
      if (!has) out.push_back(process_of(problem, accepted, before, g, kind));
    }
  }
  return out;
}

std::vector<DeviceChange> only_changes(const std::vector<FoundChange>& found, std::size_t but) {
  std::vector<DeviceChange> out;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i != but) out.push_back(found[i].change);
  }
  return out;
}

// An early change may have stood for what later ones explain better: one that the others make
// superfluous leaves.
void drop_superfluous(const ChangeProblem& problem, std::vector<FoundChange>& found,
                      double required) {
  for (std::size_t i = 0; i + 1 < found.size(); ++i) {
    const std::vector<DeviceChange> others = only_changes(found, i);
    const ChangeModel without(problem, others);
    const double before = without.log_evidence();
    const DeviceChange& c = found[i].change;
    const ChangeClass again = c.kind == ChangeKind::kStep
                                  ? steps_of(without, before, c.group)
                                  : process_of(problem, others, before, c.group, c.kind);
    if (again.log_bayes_factor >= required) continue;
    found.erase(found.begin() + std::ptrdiff_t(i));
    return;
  }
}

// The grid of sizes ends where a change needs no statistics. It may still be larger: its size is
// doubled as long as that is more probable.
void widen(const ChangeProblem& problem, std::vector<FoundChange>& found) {
  DeviceChange& c = found.back().change;
  const bool step = c.kind == ChangeKind::kStep;
  if (c.size < (step ? std::end(kStepSizes) : std::end(kProcessSizes))[-1]) return;
  const auto evidence = [&] {
    return ChangeModel(problem, only_changes(found, found.size())).log_evidence();
  };
  double best = evidence();
  for (int i = 0; i < kMostDoublings; ++i) {
    c.size *= 2.0;
    const double larger = evidence();
    if (!(larger > best)) {
      c.size /= 2.0;
      return;
    }
    best = larger;
  }
}

// Searches on from nothing. steps_first: other kinds only when no step is left to find. Two steps
// of one group look like a drift until both are in the model, and a drift in the model hides them.
std::vector<FoundChange> search(const ChangeProblem& problem, const ChangeSearchOptions& options,
                                bool steps_first) {
  const double required = -std::log(options.false_alarms);
  std::vector<FoundChange> found;
  for (std::size_t round = 0; round < options.most_changes; ++round) {
    const std::vector<ChangeClass> classes =
        classes_beside(problem, only_changes(found, found.size()));
    std::vector<double> factors;
    const ChangeClass* best = nullptr;
    for (const ChangeClass& c : classes) {
      factors.push_back(c.log_bayes_factor);
      if (steps_first && c.best.kind != ChangeKind::kStep) continue;
      if (best == nullptr || c.log_bayes_factor > best->log_bayes_factor) best = &c;
    }
    if (best == nullptr) break;
    const double all = log_mean_exp(factors), own = best->log_bayes_factor;
    const double of_classes = std::log(double(classes.size()));
    if (!((steps_first ? own - of_classes : all) > required)) {
      if (!steps_first) break;
      steps_first = false;
      continue;
    }
    // Against all other classes and, at even odds, no change.
    factors.push_back(of_classes);
    found.push_back({best->best, own, share_of(own, factors), best->date_probability});
    widen(problem, found);
    drop_superfluous(problem, found, required);
  }
  return found;
}

// A change was found beside those before it only; what it is worth is told beside all others.
void judge_beside_all(const ChangeProblem& problem, std::vector<FoundChange>& found) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    FoundChange& f = found[i];
    const std::vector<ChangeClass> classes = classes_beside(problem, only_changes(found, i));
    const auto own = std::ranges::find_if(classes, [&](const ChangeClass& c) {
      return c.best.kind == f.change.kind && c.best.group == f.change.group;
    });
    if (own == classes.end()) continue;
    std::vector<double> factors;
    for (const ChangeClass& c : classes) factors.push_back(c.log_bayes_factor);
    f.most_likely = own->log_bayes_factor >= *std::ranges::max_element(factors);
    factors.push_back(std::log(double(classes.size())));  // no change, at even odds
    f.log_bayes_factor = own->log_bayes_factor;
    f.probability = share_of(own->log_bayes_factor, factors);
    if (own->best.at == f.change.at) f.date_probability = own->date_probability;
  }
}

// Logarithm of a model's evidence times its prior, up to a constant.
double log_posterior(const ChangeProblem& problem, const std::vector<FoundChange>& found) {
  double out = ChangeModel(problem, only_changes(found, found.size())).log_evidence();
  for (const FoundChange& f : found) {
    const bool step = f.change.kind == ChangeKind::kStep;
    const double sizes = step ? double(std::size(kStepSizes)) : double(std::size(kProcessSizes));
    const double dates = step ? double(problem.recordings.size() - 1) : 1.0;
    out -= std::log(4.0 * double(problem.groups.size()) * sizes * dates);
  }
  return out;
}

}  // namespace

ChangeHistory find_changes(const ChangeProblem& problem, const ChangeSearchOptions& options) {
  ChangeHistory out;
  if (problem.recordings.size() > 1) {
    out.changes = search(problem, options, false);
    if (!out.changes.empty()) {
      std::vector<FoundChange> by_steps = search(problem, options, true);
      if (log_posterior(problem, by_steps) > log_posterior(problem, out.changes)) {
        out.changes = std::move(by_steps);
      }
    }
  }
  if (out.changes.size() > 1) judge_beside_all(problem, out.changes);
  const ChangeModel model(problem, only_changes(out.changes, out.changes.size()));
  out.smoothed = model.smoothed();
  out.log_evidence = model.log_evidence();
  out.log_evidence_unchanged = ChangeModel(problem, {}).log_evidence();
  return out;
}

}  // namespace magimu

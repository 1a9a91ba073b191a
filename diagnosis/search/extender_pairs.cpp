// SPDX-License-Identifier: BSD-3-Clause
// Two causes can hide each other: what one leaves scatters as coloured noise does, under which the
// test of the other has no power. Where none passes by itself, those are put into the model one by
// one, on trial, that leave white noise beside one of the others or that explain most of what there
// is, and what holds beside them is looked for.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "calibration/scan/change_search.h"
#include "calibration/scan/general_dependence.h"
#include "diagnosis/held/held_out_nll.h"
#include "diagnosis/search/extender.h"
#include "diagnosis/search/scan_options.h"
#include "graph/numerical_error.h"

namespace magimu {
namespace {

// Scatter of two causes' scores with both in the model (by one step), below which the rest counts
// as white: white noise has 1. The second for a bias that stands in for a change, below.
constexpr double kWhiteBeside = 1.5;
constexpr double kWhiteWithin = 1.0;

// As many windows as the search for changes has.
int bias_windows(const Stage& stage) {
  double all = 0.0;
  for (const NodePlan& plan : stage.plans()) all += plan.t.back() - plan.t.front();
  const double seconds = change_window_s(stage.plans(), Sensor::kMag, stage.spec().motion);
  return std::max(2, int(std::lround(all / seconds)));
}

}  // namespace

// Options that leave white noise beside one of the others, or explain most of all. Instead of a
// change, whose times are wrong as long as the other cause is not in the model, stands a
// magnetometer bias of its own in every window. That takes slow coloured noise with it, hence the
// lower kWhiteWithin.
std::vector<Option> Extender::firsts_of_pairs(const std::vector<Option>& options) const {
  std::vector<Option> firsts;
  std::vector<std::shared_ptr<const Effect>> effects;
  for (const Option& o : options) {
    // The times of a change would be searched for again and again; a walk may imitate the other.
    if (is_change(o.effect->name()) || o.effect->description().random_process) continue;
    firsts.push_back(o);
    effects.push_back(o.effect);
  }
  if (std::ranges::any_of(options, is_magnet,
                          [](const Option& o) -> const Effect& { return *o.effect; }) &&
      field_count(recordings_) == 1) {
    effects.push_back(bias_in_windows(bias_windows(*stage_)));
  }
  if (effects.size() < 2) return {};
  const Scan scan(recordings_, *stage_, effects);
  std::vector<Option> out;
  const double squares = 2.0 * stage_->result().cost_final;
  for (std::size_t i = 0; i < firsts.size(); ++i) {
    const bool again = std::ranges::any_of(
        out, [&](const Option& o) { return same_class(*o.effect, *firsts[i].effect); });
    if (again) continue;
    bool chosen = firsts[i].score.statistic > kMost * squares;
    for (std::size_t j = 0; j < effects.size() && !chosen; ++j) {
      const bool stands_in = j == firsts.size();
      if (i == j) continue;
      chosen = scan.scatter_with(i, j) < (stands_in ? kWhiteWithin : kWhiteBeside);
    }
    if (chosen) out.push_back(firsts[i]);
  }
  return out;
}

// Each of a pair is judged beside the other; both together may still predict worse than neither:
// what they gain in whole quarters of the recording must outweigh what they lose in windows.
bool Extender::predicts_better_than(const Stage& stage, double nll) const {
  const auto in_quarters = [&](const Stage& s) { return sum_of(held_out_nll(s, quarter_s())); };
  return (nll - nll_) + (in_quarters(stage) - in_quarters(*stage_)) > kMinGain;
}

bool Extender::try_pairs(const std::vector<Option>& options) {
  if (int(d_.findings.size()) + 2 > given_.max_findings) return false;
  struct Pair {
    Stage stage;
    double nll;
    std::vector<Finding> findings;
    std::map<std::string, Entered> entered;
  };
  const Pair alone = {*stage_, nll_, d_.findings, entered_};
  const auto put_back = [&](const Pair& pair) {
    take(pair.stage, pair.nll);
    d_.findings = pair.findings;
    entered_ = pair.entered;
  };
  const std::vector<std::string> rejected = std::exchange(rejected_, {});
  const std::vector<Option> changes = explain_most_, refused = refused_changes_;
  // Of pairs with one of the changes that explain most, the one that predicts best: beside one of
  // them the other cause may have the wrong times.
  std::optional<Pair> best;
  const auto tried = [&](const Option& first) {
    const auto holds = [&] {
      return try_beside(first, alone.stage) && predicts_better_than(alone.stage, alone.nll);
    };
    const bool found = attempt(holds).value_or(false);
    if (found && (!best || nll_ < best->nll)) best = {*stage_, nll_, d_.findings, entered_};
    put_back(alone);
    rejected_.clear();
    refused_changes_ = refused;
  };
  for (const Option& first : changes) tried(first);
  const auto firsts = attempt([&] { return firsts_of_pairs(worth_trying(options)); });
  for (const Option& first : firsts.value_or(std::vector<Option>{})) {
    if (best) break;
    tried(first);
  }
  if (best) put_back(*best);
  if (!best) rejected_ = rejected;
  return bool(best);
}

// alone: the stage without either.
bool Extender::try_beside(const Option& first, const Stage& alone) {
  // Takes the stage with this one, if it can be fitted and nothing would have to leave.
  const auto put_in = [&](const Option& option, const VectorXd& start) {
    ModelSpec spec = alone.spec();
    for (const auto& e : spec.effects) {
      if (replaces(*option.effect, e->name())) return false;
    }
    spec.effects.push_back(option.effect);
    const Stage stage = pipeline_.refit_with_same_noise(alone, spec, start);
    if (stage.result().converged()) take(stage, sum_of(held_out_nll(stage)));
    return stage.result().converged();
  };
  if (!put_in(first, first.start)) return false;
  refused_changes_.clear();  // without this one
  const std::vector<Option> seconds = scan_options(recordings_, *stage_, candidates(*stage_));
  const std::vector<Trial> found = trials(worth_trying(seconds));
  const Trial* second = best_of(found);
  if (second == nullptr || second->coloured) return false;
  Finding finding = describe(second->option, second->stage, second->nll, seconds,
                             VectorXd::Zero(second->option.effect->size()));
  finding.probability = 1.0 / (1.0 + std::exp(std::min(700.0, -second->alone)));
  entered_[finding.effect].searched = second->option.searched;
  // The first is chosen once more, as if the second had been found before it.
  if (!put_in(second->option, second->parameters())) return false;
  refused_changes_.clear();
  std::optional<Finding> other =
      try_options(scan_options(recordings_, *stage_, candidates(*stage_)));
  if (!other) return false;
  d_.findings.push_back(std::move(finding));
  d_.findings.push_back(*std::move(other));
  return true;
}

}  // namespace magimu

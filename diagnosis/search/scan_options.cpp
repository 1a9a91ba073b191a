// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/scan_options.h"

#include <algorithm>
#include <cmath>

#include "calibration/model/windows.h"
#include "calibration/motion/random_walk.h"
#include "calibration/scan/change_search.h"
#include "diagnosis/search/shapes/source_search.h"
#include "factors/effects/catalogue.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kOrders = 3.0;   // of a family: one, two or three terms
constexpr double kPlaces = 10.0;  // of a source: independent tests, beyond the place's 3 parameters

// Columns first .. first + count - 1 of all.
MatrixXd selection(Eigen::Index all, int first, int count) {
  MatrixXd C = MatrixXd::Zero(all, count);
  C.middleRows(first, count).setIdentity();
  return C;
}

// The effects' scores, each by windows of the length that its sensor needs.
std::vector<Score> scores_by_channel(const std::vector<const Recording*>& recordings,
                                     const Stage& stage, const Scan& scan,
                                     const std::vector<std::shared_ptr<const Effect>>& effects) {
  std::vector<Score> out(scan.scores().begin(),
                         scan.scores().begin() + std::ptrdiff_t(effects.size()));
  const double longer = window_s(Sensor::kAcc, stage.spec().motion);
  if (longer == window_s(Sensor::kMag, stage.spec().motion)) return out;
  std::vector<std::shared_ptr<const Effect>> acc;
  for (const auto& e : effects) {
    if (e->channel() == Sensor::kAcc) acc.push_back(e);
  }
  if (acc.empty()) return out;
  const Scan again(recordings, stage, acc, longer);
  auto score = again.scores().begin();
  for (Score& s : out) {
    if (s.effect->channel() == Sensor::kAcc) s = *score++;
  }
  return out;
}

// A bias that wanders: by the density of its walk.
void take_walk(Option& option, const Scan& scan, std::size_t candidate, double duration_s) {
  const Effect& effect = *option.effect;
  const VectorXd unit = effect.prior_sigma(duration_s);
  const Score& s = scan.scores()[candidate];
  const VectorXd z = scan.score().segment(scan.first(candidate), unit.size());
  const RandomWalk walk = estimate_random_walk(s.information, z, unit);
  option.score.statistic = walk.likelihood_ratio;
  option.score.dof = 1;
  option.rank = walk.log10_p;
  // Coloured noise makes a walk look larger.
  option.score.log10_p =
      s.coloured ? estimate_random_walk(s.information, z, unit, s.scatter).log10_p : walk.log10_p;
  option.extra = {{"q", walk.density, walk.sigma, "rad/s per sqrt(s)"}};
  option.effect = make_gyro_bias_walk(effect.size() / 3, std::max(walk.density, 1e-9));
}

// A family: with the number of terms that is the most significant.
void take_terms(Option& option, const Scan& scan, std::size_t candidate) {
  const std::shared_ptr<const Effect> family = option.effect;
  double best = 1.0;
  for (int terms = 1;; ++terms) {
    const std::shared_ptr<const Effect> one = family->with_terms(terms);
    if (one->size() > family->size()) break;
    const Score s =
        scan.combined(selection(scan.information().rows(), scan.first(candidate), one->size()));
    const double rank = log10_chi_square_tail(s.statistic, s.dof);
    if (terms > 1 && rank >= best) continue;
    best = rank;
    option.score = s;
    option.effect = one;
    option.rank = rank;
  }
  option.score.log10_p = std::min(0.0, option.score.log10_p + std::log10(kOrders));
  option.searched = std::log(kOrders);
}

// score: of the change at these times.
Option change_option(const LikelyChange& change, const Score& score) {
  const double forms = double(forms_of_change(change.name).size());
  Option option{.effect = score.effect,
                .score = score,
                .start = score.theta,
                .span = change.span,
                // Its times are paid for when they are known (cost_of_times).
                .searched = std::log(2.0 * forms)};
  option.rank =
      std::min(0.0, log10_chi_square_tail(score.statistic, score.dof) + std::log10(change.tried));
  option.score.log10_p = std::min(0.0, score.log10_p + std::log10(change.tried));
  return option;
}

// The best changes of all kinds that the model does not have yet, and of another magnet.
std::vector<LikelyChange> changes_to_scan(const std::vector<const Recording*>& recordings,
                                          const Stage& stage) {
  std::vector<std::string> names = change_names();
  std::erase_if(names, [&](const std::string& name) {
    return name != "hard_iron_change" &&
           std::ranges::any_of(stage.spec().effects,
                               [&](const auto& e) { return e->name() == name; });
  });
  return likely_changes(recordings, stage, names);
}

Option source_option(const Score& score, const Vector3& place) {
  Option option{.effect = find_effect("stationary_source"), .score = score};
  option.start.resize(6);
  option.start << place, score.theta;
  // A place is three parameters more, searched for among hundreds.
  option.score.dof += 3;
  option.rank = log10_chi_square_tail(score.statistic, option.score.dof);
  option.score.log10_p = std::min(0.0, std::max(score.log10_p, option.rank) + std::log10(kPlaces));
  option.searched = std::log(kPlaces);
  return option;
}

}  // namespace

std::vector<Option> scan_options(const std::vector<const Recording*>& recordings,
                                 const Stage& stage,
                                 const std::vector<std::shared_ptr<const Effect>>& effects) {
  const Recording& recording = *recordings.front();
  const bool single = recordings.size() == 1;
  std::vector<std::shared_ptr<const Effect>> all = effects;
  const std::vector<LikelyChange> changes = changes_to_scan(recordings, stage);
  for (const LikelyChange& c : changes) all.push_back(c.effect());
  std::vector<LikelySource> sources;
  if (single && recording.pos) sources = likely_sources(recordings, stage);
  for (const LikelySource& s : sources) all.push_back(make_stationary_source_at(s.place));
  const Scan scan(recordings, stage, all);
  const std::vector<Score> scores = scores_by_channel(recordings, stage, scan, effects);

  std::vector<Option> out;
  for (std::size_t i = 0; i < effects.size(); ++i) {
    Option option{.effect = effects[i], .score = scores[i]};
    if (effects[i]->name() == "gyro_bias_drift") {
      take_walk(option, scan, i, longest_s(recordings));
    } else if (effects[i]->with_terms(1)) {
      take_terms(option, scan, i);
    } else {
      option.rank = log10_chi_square_tail(option.score.statistic, option.score.dof);
    }
    // Of two that are the same to first order, the offset is the simpler.
    if (effects[i]->name() == "mag_lag") option.rank *= 1.0 - 1e-6;
    out.push_back(option);
  }
  for (std::size_t c = 0; c < changes.size(); ++c) {
    const Score& score = scan.scores()[effects.size() + c];
    if (score.dof > 0) out.push_back(change_option(changes[c], score));
  }
  for (std::size_t s = 0; s < sources.size(); ++s) {
    out.push_back(
        source_option(scan.scores()[effects.size() + changes.size() + s], sources[s].place));
  }
  std::sort(out.begin(), out.end(),
            [](const Option& a, const Option& b) { return a.rank < b.rank; });
  return out;
}

}  // namespace magimu

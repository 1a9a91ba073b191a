// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/search/finding_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/scan/testable.h"
#include "diagnosis/result/sentence_words.h"
#include "factors/effects/change.h"
#include "statistics/tails.h"

namespace magimu {
namespace {

constexpr double kAlike = 0.5;  // of the statistic that another candidate explains, too

// Sizes along parameters that are components of one vector or matrix.
struct AlikeSizes {
  std::string symbol = {}, unit = {}, words = {};
  double scale = 1.0;  // from the parameter's unit to this one
  double least = INFINITY, most = 0.0;
};

// What the parameter is a component of: a number, a vector, the coefficients of a course over time,
// a matrix.
AlikeSizes no_sizes_of(const Effect& effect, const Effect::Parameter& p) {
  AlikeSizes out{.symbol = p.name.substr(0, p.name.find('[')), .unit = p.unit};
  const auto indices = std::ranges::count(p.name, '[');
  if (indices == 1) out.words = "along an axis ";
  if (indices == 2) {
    const bool drifts = effect.name().ends_with("_drift");
    out.words = drifts ? "coefficients of its course " : "entries of its matrix ";
    if (!drifts) return out;
  }
  if (p.unit == "1") {
    out.unit = "%";
    out.scale = 100.0;
  }
  return out;
}

// Sizes are known to a figure; from ten on without a power of ten.
std::string shown_size(double size) {
  return size < 9.5 ? fmt::format("{:.1g}", size) : two_figures(size);
}

std::string text_of(const AlikeSizes& sizes) {
  constexpr double kAlikeSizes = 2.0;
  std::string out = sizes.words;
  if (sizes.most > kAlikeSizes * sizes.least) out += shown_size(sizes.least) + " to ";
  out += shown_size(sizes.most);
  return sizes.unit == "1" ? out : out + " " + sizes.unit;
}

// The size that the scan would have found nine times out of ten, along each parameter; of those
// that are alike the largest, or the range.
std::string detectable(const Option& option, double log10_level) {
  const double size = detectable_size(option.score.dof, log10_level);
  const Effect& effect = *option.effect;
  constexpr double kNotTold = 100.0;  // times the usual size
  std::vector<AlikeSizes> all;
  for (int i = 0; i < option.score.information.rows() && i < effect.size(); ++i) {
    const double a = option.score.information(i, i);
    const Effect::Parameter& p = effect.description().parameters[std::size_t(i)];
    const double least = a > 0.0 ? size / std::sqrt(a) : INFINITY;
    if (least > kNotTold * p.prior_sigma) continue;
    const AlikeSizes none = no_sizes_of(effect, p);
    auto same = std::ranges::find_if(
        all, [&](const AlikeSizes& s) { return s.symbol == none.symbol && s.unit == none.unit; });
    if (same == all.end()) same = all.insert(all.end(), none);
    same->least = std::min(same->least, none.scale * least);
    same->most = std::max(same->most, none.scale * least);
  }
  std::string out;
  for (const AlikeSizes& sizes : all) out += (out.empty() ? "" : ", ") + text_of(sizes);
  return out;
}

}  // namespace

double detectable_size(int dof, double log10_level) {
  constexpr double kFarthest = 1e6;  // beyond any level that a test asks for
  double x = 1.0;
  while (x < kFarthest && log10_chi_square_tail(x, std::max(1, dof)) > log10_level) x *= 1.05;
  return std::sqrt(x) + 1.28;
}

std::string walk_sentence(const FoundParameter& density) {
  return fmt::format(
      "The gyroscope's bias wanders: a random walk of {:.2g} +- {:.1g} rad/s per root second, "
      "{:.2g} deg/s in a minute.",
      density.value, density.sigma, density.value * std::sqrt(60.0) * 180.0 / M_PI);
}

std::vector<Confusable> confusable(const Option& option, const std::vector<Option>& all) {
  std::vector<Confusable> out;
  for (const Option& o : all) {
    const std::string& name = o.effect->name();
    if (name == option.effect->name()) continue;
    if (std::any_of(out.begin(), out.end(),
                    [&](const Confusable& c) { return c.effect == name; })) {
      continue;
    }
    const double share = o.score.statistic / std::max(option.score.statistic, 1e-12);
    const std::string motion = o.effect->description().separating_motion;
    if (same_class(*o.effect, *option.effect)) {
      out.push_back({name, "the two are the same to first order in the delay", motion});
    } else if (share > kAlike) {
      out.push_back({name,
                     fmt::format("{:.0f} % of the same misfit with this motion",
                                 100.0 * std::min(1.0, share)),
                     motion});
    }
  }
  return out;
}

std::vector<ScanEntry> scan_entries(const std::vector<Option>& options,
                                    const std::vector<const Recording*>& recordings,
                                    const Stage& stage, double log10_level) {
  std::vector<ScanEntry> out;
  for (const Option& o : options) {
    const std::string& name = o.effect->name();
    if (std::any_of(out.begin(), out.end(), [&](const ScanEntry& e) { return e.effect == name; })) {
      continue;
    }
    ScanEntry entry{.effect = name, .channel = to_string(o.effect->channel())};
    for (const auto& p : o.effect->description().parameters) entry.parameters.push_back(p.name);
    if (!o.extra.empty()) {
      entry.parameters.clear();
      for (const auto& p : o.extra) entry.parameters.push_back(p.name);
    }
    entry.statistic = o.score.statistic;
    entry.dof = o.score.dof;
    entry.p_value = std::pow(10.0, std::max(-300.0, o.score.log10_p));
    entry.significant = o.score.log10_p < log10_level;
    if (!entry.significant && o.score.dof > 0) entry.detectable = detectable(o, log10_level);
    if (!entry.significant && entry.detectable.empty()) {
      entry.needs = "the motion shows nothing of it";
      entry.p_value = 1.0;
    }
    out.push_back(std::move(entry));
  }
  std::stable_sort(out.begin(), out.end(), [](const ScanEntry& a, const ScanEntry& b) {
    return a.p_value != b.p_value
               ? a.p_value < b.p_value
               : a.statistic / std::max(1, a.dof) > b.statistic / std::max(1, b.dof);
  });
  for (const auto& effect : effect_catalogue()) {
    if (effect->name() == "mag_coupling") continue;  // array_coupling.h, where there are several
    const std::string reason = reason_untested(*effect, recordings, stage);
    const bool listed = std::ranges::find(out, effect->name(), &ScanEntry::effect) != out.end();
    // A change of which no time says more than chance.
    const bool nowhere = is_change(effect->name()) && !listed;
    if (reason.empty() && !nowhere) continue;
    ScanEntry entry{.effect = effect->name(), .channel = to_string(effect->channel())};
    for (const auto& p : effect->description().parameters) entry.parameters.push_back(p.name);
    if (reason.empty()) entry.dof = effect->size();
    entry.needs = reason;
    out.push_back(std::move(entry));
  }
  return out;
}

}  // namespace magimu
